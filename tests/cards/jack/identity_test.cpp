// Is it still the device that the drives were armed for? On a real JACK server.
#include <dlfcn.h>
#include <jack/jack.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <map>

#include "backends/reconnecting_stream.h"
#include "tests/cards/ways.h"
#include "tests/support/noise_probe.h"
#include "tests/support/sound_server.h"
#include "tests/support/wait_until.h"

using namespace tactus;
using namespace std::chrono_literals;
using test::DelayClient;
using test::GuardedProbe;
using test::start_sound_server;
using test::wait_until;

namespace {

struct RateCallback {
  JackSampleRateCallback call = nullptr;
  void* argument = nullptr;
};
RateCallback last_rate_callback;

/// A player on both channels of a card, looked after as an application does it.
struct Player {
  explicit Player(DelayClient::Settings settings) : card(std::make_unique<DelayClient>(settings)) {
    StreamRequest request;
    request.device = "jack:" + card->name();
    request.in_channels = request.out_channels = 2;
    request.client_name = name;
    auto opened = ReconnectingStream::open(*jack, request, probe.guarded);
    REQUIRE(opened);
    stream = std::move(*opened);
    stream->on_return([this](const Return& back) { returns.push_back(back); });
    REQUIRE(stream->start());
  }
  template <class Condition>
  bool until(Condition holds) {
    return wait_until([&] {
      stream->tick();
      while (auto event = stream->take_event()) events += *event + "\n";
      return holds();
    });
  }
  bool plays_on() {
    const auto frames = probe.probe.frames();
    return until([&] { return probe.probe.frames() > frames; });
  }
  /// The card is gone, and back with these settings.
  const Return& replace_card(DelayClient::Settings settings) {
    card.reset();
    REQUIRE(until([&] { return stream->state() == StreamState::Lost; }));
    const auto before = returns.size();
    card = std::make_unique<DelayClient>(settings);
    REQUIRE(until([&] { return returns.size() > before; }));
    return returns.back();
  }

  std::string name = "tactus-" + std::to_string(::getpid());
  std::unique_ptr<DelayClient> card;
  GuardedProbe probe{2, 4800};
  std::unique_ptr<Backend> jack = test::backend_named("jack");
  std::unique_ptr<ReconnectingStream> stream;
  std::vector<Return> returns;
  std::string events;
};

}  // namespace

/// Seen by the test; jackd itself cannot change its rate.
extern "C" int jack_set_sample_rate_callback(jack_client_t* client, JackSampleRateCallback call,
                                             void* argument) {
  last_rate_callback = {call, argument};
  const auto real = reinterpret_cast<decltype(&jack_set_sample_rate_callback)>(
      ::dlsym(RTLD_NEXT, "jack_set_sample_rate_callback"));
  return real == nullptr ? -1 : real(client, call, argument);
}

TEST_CASE("jack: the same card is the same when it is back, another one is not", "[cards][jack]") {
  const auto server = start_sound_server();
  Player player{{}};
  CHECK(player.replace_card({}).same());
  const auto& other = player.replace_card({.channels = 4});
  CHECK(other.differences.size() == 2);  // inputs and outputs
  CHECK(player.events.find("it has 4 outputs instead of 2") != std::string::npos);
}

TEST_CASE("jack: an equal card on other hardware, or one of unknown hardware, is not the same",
          "[cards][jack][slow]") {
  const auto server = start_sound_server();
  const std::string card_a = "dummy_pcm:A", card_b = "dummy_pcm:B";
  Player player{{.hardware = card_a}};
  CHECK(player.replace_card({.hardware = card_a}).same());
  CHECK(player.replace_card({.hardware = card_b}).differences.size() == 2);
  // No hardware is known by an alias alone: another card may have it tomorrow.
  const std::string unknown =
      GENERATE(as<std::string>{}, "", "usb", "alsa_pcm:default", "alsa_pcm:front:1",
               "alsa_pcm:sysdefault:CARD=USB", "alsa_pcm:dmix:99,0", "alsa_pcm:hw:99");
  CAPTURE(unknown);
  CHECK_FALSE(player.replace_card({.hardware = unknown}).same());
  CHECK_FALSE(player.replace_card({.hardware = unknown}).same());
  CHECK(player.events.find("it may be another device of the same name: check its outputs") !=
        std::string::npos);
}

TEST_CASE("jack: the sound card of a server that was killed is the same when it is back", "[cards][jack]") {
  const auto server = start_sound_server();
  GuardedProbe probe{1};
  const auto jack = test::backend_named("jack");
  StreamRequest request;
  request.device = "jack:system";
  request.in_channels = request.out_channels = 1;
  request.client_name = "tactus-" + std::to_string(::getpid());
  auto opened = ReconnectingStream::open(*jack, request, probe.guarded);
  REQUIRE(opened);
  auto& stream = **opened;
  std::vector<Return> returns;
  stream.on_return([&](const Return& back) { returns.push_back(back); });
  REQUIRE(stream.start());
  CHECK(stream.granted().output.ports == std::vector<std::string>{"system:playback_1"});
  CHECK(stream.granted().output.channels == server->settings().channels);
  server->kill();
  server->restart();
  REQUIRE(wait_until([&] { return stream.tick(), returns.size() == 1; }));
  CHECK(returns[0].same());
}

TEST_CASE("jack: a card that registers its ports the other way round gets the same outputs on the same ports",
          "[cards][jack]") {
  const auto server = start_sound_server();
  Player player{{}};
  CHECK(player.replace_card({.reversed = true}).same());
  for (const std::string channel : {"1", "2"}) {
    CAPTURE(channel);
    CHECK(server->connections(player.card->name() + ":playback_" + channel) ==
          player.name + ":out_" + channel + "\n");
    CHECK(server->connections(player.card->name() + ":capture_" + channel) ==
          player.name + ":in_" + channel + "\n");
  }
}

TEST_CASE("jack: a card whose ports exchange their names while it plays is not the same", "[cards][jack]") {
  const auto server = start_sound_server();
  Player player{{}};
  REQUIRE(player.plays_on());
  const auto other = std::shared_ptr<jack_client_t>{jack_client_open("renames", JackNoStartServer, nullptr),
                                                    jack_client_close};
  REQUIRE(other != nullptr);
  const auto playback = [&](int channel) {
    const auto name = player.card->name() + ":playback_" + std::to_string(channel);
    return jack_port_by_name(other.get(), name.c_str());
  };
  auto *first = playback(1), *second = playback(2);
  REQUIRE(jack_port_rename(other.get(), first, "held") == 0);
  REQUIRE(jack_port_rename(other.get(), second, "playback_1") == 0);
  REQUIRE(jack_port_rename(other.get(), first, "playback_2") == 0);
  REQUIRE(player.until([&] { return player.returns.size() == 1; }));
  REQUIRE_FALSE(player.returns[0].same());
  CHECK(player.returns[0].differences.back() == "its ports were renamed");
  CHECK(player.plays_on());
}

TEST_CASE("jack: who else writes to the ports of the outputs is found, who reads is not", "[cards][jack]") {
  const auto server = start_sound_server();
  const DelayClient other{{.name = "other"}};
  Player player{{}};
  REQUIRE(player.plays_on());
  CHECK(player.stream->other_writers().empty());
  server->connect(player.name + ":out_1", other.name() + ":playback_1");
  server->connect(player.card->name() + ":capture_1", other.name() + ":playback_2");
  const auto to = player.card->name() + ":playback_2", from = other.name() + ":capture_1";
  server->connect(from, to);
  CHECK(player.until([&] { return !player.stream->other_writers().empty(); }));
  CHECK(player.stream->other_writers() == std::vector<OtherWriter>{{1, from, to}});
  server->disconnect(other.name());
  CHECK(player.until([&] { return player.stream->other_writers().empty(); }));
  // An output on another actuator's port has passed the wrong guard.
  server->connect(player.name + ":out_2", "system:playback_3");
  CHECK(player.until([&] { return !player.stream->other_writers().empty(); }));
  CHECK(player.stream->other_writers() ==
        std::vector<OtherWriter>{{1, player.name + ":out_2", "system:playback_3"}});
}

TEST_CASE("jack: a writer that came and went between two looks is found once", "[cards][jack]") {
  const auto server = start_sound_server();
  const DelayClient other{{.name = "other"}};
  Player player{{}};
  REQUIRE(player.plays_on());
  REQUIRE(player.stream->other_writers().empty());
  const auto to = player.card->name() + ":playback_2", from = other.name() + ":capture_1";
  server->connect(from, to);
  server->disconnect(other.name());
  std::vector<OtherWriter> found;
  REQUIRE(wait_until([&] { return !(found = player.stream->other_writers()).empty(); }));
  CHECK(found == std::vector<OtherWriter>{{1, from, to}});
  CHECK(wait_until([&] { return player.stream->other_writers().empty(); }));
}

TEST_CASE("jack: while the server freewheels outputs are silent and no time passes for the guards",
          "[cards][jack]") {
  const auto server = start_sound_server();
  Player player{{}};
  REQUIRE(player.plays_on());
  server->freewheel(true);
  const auto frame = player.probe.guarded.frame();
  const auto xruns = player.stream->health().xruns;
  const DelayClient during{{.name = "during"}};  // has registered, activated and connected: freewheel ran on
  CHECK(player.probe.guarded.frame() == frame);
  CHECK(player.stream->state() == StreamState::Running);
  server->freewheel(false);
  REQUIRE(player.plays_on());
  CHECK(player.stream->returns() == 0);
  CHECK(player.stream->health().gaps[static_cast<std::size_t>(Gap::Unsaid)] == 0);
  CHECK(player.stream->health().xruns >= xruns);
}

TEST_CASE("jack: a server that changes its rate is lost, and opened again at the granted rate alone",
          "[cards][jack]") {
  const auto server = start_sound_server();
  Player player{{}};
  REQUIRE(player.plays_on());
  const auto callback = last_rate_callback;
  REQUIRE(callback.call != nullptr);
  callback.call(48000, callback.argument);
  CHECK(player.stream->state() == StreamState::Running);
  callback.call(96000, callback.argument);
  CHECK(player.stream->state() == StreamState::Lost);
  REQUIRE(player.until([&] { return player.returns.size() == 1; }));  // the server itself is as it was
  CHECK(player.events.find("the sample rate is now 96000 Hz instead of 48000") != std::string::npos);
  CHECK(player.stream->granted().format.sample_rate == 48_kHz);
}
