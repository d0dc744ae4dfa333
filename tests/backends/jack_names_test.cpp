#include "backends/jack_names.h"

#include <catch2/catch.hpp>

#include "backends/find_device.h"
#include "tests/support/error_summary.h"

using namespace tactus;

namespace {

struct Client {
  std::string name;
  int in_channels = 2, out_channels = 2;  ///< as the library counts them
};

/// As a library lists them over JACK, in the server's order.
std::vector<Device> listed(const std::vector<Client>& clients) {
  std::vector<Device> devices;
  for (const auto& client : clients) {
    Device device;
    device.api = "jack";
    device.library_name = client.name;
    device.id = device.name = "rtaudio:jack:" + client.name;
    device.index = static_cast<int>(devices.size());
    device.in_channels = client.in_channels;
    device.out_channels = client.out_channels;
    devices.push_back(device);
  }
  return devices;
}

/// Those that are left, as "NAME INPUTS/OUTPUTS".
std::string usable(const std::vector<Client>& clients, JackSearch search = JackSearch::Anywhere) {
  std::string text;
  for (const auto& device : own_ports_only(listed(clients), search, {}))
    text += (text.empty() ? "" : ", ") + device.library_name + " " + std::to_string(device.in_channels) +
            "/" + std::to_string(device.out_channels);
  return text;
}

}  // namespace

TEST_CASE(
    "jack names: a client whose name is a regular expression is left out, alone or beside what it matches",
    "[backends]") {
  const std::string name =
      GENERATE(as<std::string>{}, "a.c", "card (x)", "card)", "USB [1-2]", "USB]", "card+", "ca*rd", "card?",
               "card|foo", "^card", "card$", "card{2}", "card}", "card\\");
  CAPTURE(name);
  CHECK(is_regular_expression(name));
  for (const auto search : {JackSearch::Anywhere, JackSearch::AtEndOfName}) {
    CHECK(usable({{"system"}, {name}}, search) == "system 2/2");
    CHECK(usable({{name}, {"system"}}, search) == "system 2/2");
    CHECK(usable({{"abc"}, {name, 0, 0}}, search) == "abc 2/2");
  }
}

TEST_CASE("jack names: other characters mean themselves", "[backends]") {
  for (const std::string name :
       {"card", "USB Audio 2", "my-card_2", "a&b", "card's #1", "Gerät", "a/b,c;d=e~f"})
    CHECK_FALSE(is_regular_expression(name));
  CHECK(usable({{"system"}, {"USB Audio 2"}, {"a&b"}}) == "system 2/2, USB Audio 2 2/2, a&b 2/2");
}

TEST_CASE("jack names: a client whose name is in another's has its own ports only if they come first",
          "[backends]") {
  // RtAudio counts the ports of both.
  CHECK(usable({{"card", 5, 6}, {"my-card", 3, 4}}) == "card 2/2, my-card 3/4");
  CHECK(usable({{"my-card", 3, 4}, {"card", 5, 6}}) == "my-card 3/4");
  CHECK(usable({{"card", 4, 4}, {"card 2", 2, 2}, {"x"}}) == "card 2/2, card 2 2/2, x 2/2");
  // Its ports do not lie together.
  CHECK(usable({{"card", 2, 2}, {"x"}, {"card", 2, 2}}) == "card 2/2, x 2/2");
}

TEST_CASE("jack names: PortAudio takes a client for those whose names end like its name", "[backends]") {
  constexpr auto search = JackSearch::AtEndOfName;
  CHECK(usable({{"card", 4, 4}, {"my-card"}}, search) == "my-card 2/2");
  CHECK(usable({{"my-card"}, {"card", 4, 4}}, search) == "my-card 2/2");
  CHECK(usable({{"card"}, {"card 2"}}, search) == "card 2/2, card 2 2/2");
}

TEST_CASE("jack names: a client is left out whose name is in that of one whose ports cannot be counted",
          "[backends]") {
  for (const auto search : {JackSearch::Anywhere, JackSearch::AtEndOfName})
    for (const int counted : {0, 2}) {
      CHECK(usable({{"card", 4, 4}, {"x.card", counted, counted}, {"y"}}, search) == "y 2/2");
      CHECK(usable({{"x.card", counted, counted}, {"card", 4, 4}, {"y"}}, search) == "y 2/2");
    }
}

namespace {

constexpr auto kAnywhere = JackSearch::Anywhere, kAtEnd = JackSearch::AtEndOfName;

/// What is left of a client "card" that a library lists with so many channels, beside these ports of all
/// clients; those that begin with "<" give sound.
std::string card_beside(int in_channels, int out_channels, JackSearch search,
                        const std::vector<std::string>& names) {
  std::vector<JackPort> ports;
  for (const auto& name : names) {
    const bool gives = name.starts_with('<');
    ports.push_back({gives ? name.substr(1) : name, !gives});
  }
  std::string text;
  for (const auto& device : own_ports_only(listed({{"card", in_channels, out_channels}}), search, ports))
    text += std::to_string(device.in_channels) + "/" + std::to_string(device.out_channels);
  return text;
}

}  // namespace

TEST_CASE("jack names: a client is left out when a port of another one would be opened for one of its own",
          "[backends]") {
  for (const auto search : {kAnywhere, kAtEnd}) {
    CHECK(card_beside(0, 2, search, {"card:out_1", "card:out_2"}) == "0/2");
    CHECK(card_beside(1, 2, search, {"<card:in", "card:out_1", "card:out_2"}) == "1/2");
    CHECK(card_beside(0, 3, search, {"foo:card:p_1", "card:out_1", "card:out_2"}) == "");
    CHECK(card_beside(1, 2, search, {"<foo:card:p_1", "<card:in", "card:out_1", "card:out_2"}) == "");
    // Ports that only give sound are no output, and the card has no input.
    CHECK(card_beside(1, 2, search, {"<foo:card:p_1", "card:out_1", "card:out_2"}) == "0/2");
    CHECK(card_beside(0, 2, search, {}) == "");
  }
}

TEST_CASE("jack names: RtAudio finds a name anywhere in a port's, and opens the first ports", "[backends]") {
  CHECK(card_beside(0, 3, kAnywhere, {"foo:card_1", "card:out_1", "card:out_2"}) == "");
  CHECK(card_beside(0, 3, kAnywhere, {"foo:to_card", "card:out_1", "card:out_2"}) == "");
  CHECK(card_beside(0, 3, kAnywhere, {"card:out_1", "card:out_2", "foo:card_1"}) == "0/2");
  CHECK(card_beside(0, 3, kAnywhere, {"card:out_1", "foo:card_1", "card:out_2"}) == "");
}

TEST_CASE("jack names: PortAudio finds a name before a colon alone, and may open any of them", "[backends]") {
  CHECK(card_beside(0, 2, kAtEnd, {"foo:card_1", "card:out_1", "card:out_2"}) == "0/2");
  CHECK(card_beside(0, 3, kAtEnd, {"card:out_1", "card:out_2", "foo:card:p_1"}) == "");
}

TEST_CASE("jack names: devices over other APIs stay as they are", "[backends]") {
  auto devices = listed({{"card (hw:0,0)"}, {"card"}, {"my-card"}});
  devices[0].api = "alsa";
  const auto usable = own_ports_only(devices, JackSearch::AtEndOfName, {});
  REQUIRE(usable.size() == 2);
  CHECK(usable[0].library_name == "card (hw:0,0)");
  CHECK(usable[1].library_name == "my-card");
}

TEST_CASE("jack names: the error for a client that was left out names the backend that lists it",
          "[backends]") {
  const auto devices =
      own_ports_only(listed({{"system"}, {"abc"}, {"a.c"}, {"my-card"}, {"card"}}), JackSearch::Anywhere, {});
  const auto answer = [&](const std::string& id) { return test::summary(device_with_id(devices, id)); };
  CHECK(answer("rtaudio:jack:abc").empty());
  CHECK(answer("rtaudio:jack:a.c") == "UnknownName 'rtaudio:jack:a.c' --backend");
  CHECK(answer("rtaudio:jack:card") == "UnknownName 'rtaudio:jack:card' --backend");
  CHECK(test::summary(find_device(devices, "a.c")) == "UnknownName 'a.c' --backend");
  CHECK(test::summary(find_device(devices, "rtaudio:jack:card")) == answer("rtaudio:jack:card"));
  CHECK(find_device(devices, "card")->library_name == "my-card");
  const std::string all = "'rtaudio:jack:system' 'rtaudio:jack:abc' 'rtaudio:jack:my-card'";
  CHECK(answer("rtaudio:jack:other") == "UnknownName 'rtaudio:jack:other' " + all + " --backend");
  CHECK(answer("rtaudio:alsa:hw:USB (1)") == "UnknownName 'rtaudio:alsa:hw:USB (1)' " + all);
  CHECK_FALSE(is_left_out("a.c", {}));
  auto of_jack_itself = devices;
  for (auto& device : of_jack_itself) device.api.clear();
  CHECK_FALSE(is_left_out("jack:a.c", of_jack_itself));
}
