#include "remote/osc/osc_host.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdlib>
#include <random>
#include <string>
#include <vector>

#include "remote/osc/osc_query.h"
#include "tests/remote/fake_remote_target.h"
#include "tests/remote/osc/osc_bytes.h"

using namespace tactus;
using namespace std::chrono_literals;
using Kind = RemoteOrder::Kind;
using test::bundle_of;
using test::bytes;

namespace {

constexpr double kNow_s = 1.8e9;

OscPeer peer(std::uint16_t port, bool local = true) {
  OscPeer from;
  from.port = port;
  from.local = local;
  from.address[15] = local ? 1 : 2;
  return from;
}

/// Clients of a fake target; time is what the test says.
class Stage {
 public:
  explicit Stage(bool arm_from_elsewhere = false)
      : host{target, [this](const OscPeer& to, std::span<const char> bytes) { receive(to, bytes); },
             arm_from_elsewhere} {}

  void send(const OscMessage& message, const OscPeer& from = peer(1)) {
    send_bundle({message}, OscBundle::kNow, from);
  }
  void send_bundle(const std::vector<OscMessage>& messages, double time_s, const OscPeer& from = peer(1)) {
    for (const auto& packet : build_osc(messages, time_s)) host.receive(from, packet, now, now_s());
  }
  void pass(std::chrono::milliseconds time) {
    for (const auto end = now + time; now < end;) {
      now += 10ms;
      host.tick(now, now_s());
    }
  }
  double now_s() const { return kNow_s + std::chrono::duration<double>{now.time_since_epoch()}.count(); }
  /// What a client received, and no more.
  std::vector<OscMessage> take(std::uint16_t port = 1) {
    std::vector<OscMessage> all;
    std::erase_if(received, [&](const auto& entry) {
      if (entry.first.port == port) all.push_back(entry.second);
      return entry.first.port == port;
    });
    return all;
  }
  /// The text of the only answer, which is an error; "" if it is none.
  std::string error(std::uint16_t port = 1) {
    const auto answers = take(port);
    if (answers.size() != 1 || answers[0].address != "/error") return "";
    return std::get<std::string>(answers[0].values.at(0));
  }
  std::int64_t arm_number(const OscPeer& from = peer(1)) {
    send({"/arm/request"}, from);
    const auto answers = take(from.port);
    REQUIRE(answers.size() == 1);
    REQUIRE(answers[0].address == "/arm/number");
    return std::get<std::int64_t>(answers[0].values.at(0));
  }
  /// The only order so far.
  RemoteOrder order() {
    REQUIRE(target.bundles.size() == 1);
    REQUIRE(target.bundles[0].size() == 1);
    const auto only = target.bundles[0][0];
    target.bundles.clear();
    return only;
  }

  test::FakeRemoteTarget target;
  OscHost::Clock::time_point now{1h};
  std::vector<std::pair<OscPeer, OscMessage>> received;
  OscHost host;

 private:
  void receive(const OscPeer& to, std::span<const char> bytes) {
    const auto read = parse_osc(bytes, now_s());
    REQUIRE(read);
    for (const auto& bundle : *read)
      for (const auto& message : bundle.messages) received.emplace_back(to, message);
  }
};

}  // namespace

TEST_CASE("osc host: controls are set in their own unit, by any kind of number or a text", "[remote][osc]") {
  Stage stage;
  const auto set = [&](const std::string& name, const OscValue& value) {
    stage.send({"/control/" + name, {value}});
    const auto order = stage.order();
    CHECK(order.kind == Kind::Set);
    CHECK(order.ramp_s == 0.0);
    CHECK(order.time_s == RemoteOrder::kNow);
    return order.value;
  };
  CHECK(set("strength", 0.5) == 0.5);
  CHECK(set("strength", std::int64_t{1}) == 1.0);
  CHECK(set("strength", std::string{"50 %"}) == 0.5);
  CHECK(set("hold", 15.0) == Approx(0.015));
  CHECK(set("hold", std::string{"15 ms"}) == Approx(0.015));
  CHECK(set("hold", std::string{"0.015 s"}) == Approx(0.015));
  CHECK(set("hold", std::string{"15"}) == Approx(0.015));
  CHECK(set("level", -20.0) == Approx(0.1));
  CHECK(set("level", std::string{"-20 dB"}) == Approx(0.1));
  CHECK(stage.take().empty());
}

TEST_CASE("osc host: a second argument is a ramp", "[remote][osc]") {
  Stage stage;
  stage.send({"/control/strength", {0.5, 2.0}});
  CHECK(stage.order().ramp_s == 2.0);
  stage.send({"/control/strength", {0.5, std::string{"200 ms"}}});
  CHECK(stage.order().ramp_s == Approx(0.2));
  for (const OscValue& wrong :
       {OscValue{-1.0}, OscValue{1e9}, OscValue{std::nan("")}, OscValue{std::string{"2 m"}}}) {
    stage.send({"/control/strength", {0.5, wrong}});
    CHECK(stage.error().find("ramp") != std::string::npos);
  }
  CHECK(stage.target.bundles.empty());
}

TEST_CASE("osc host: a value outside of the range is clamped, and that is reported once", "[remote][osc]") {
  Stage stage;
  stage.send({"/control/hold", {200.0}});
  CHECK(stage.order().value == 0.1);
  CHECK(stage.error().find("hold: it runs from 2 ms to 100 ms") == 0);
  stage.send({"/control/hold", {1.0}});
  CHECK(stage.order().value == 0.002);
  CHECK(stage.take().empty());
  stage.send({"/control/hold", {50.0}});
  (void)stage.order();
  stage.send({"/control/hold", {1.0}});
  CHECK(stage.error() != "");
}

TEST_CASE("osc host: what float32 rounds beyond a limit is no error", "[remote][osc]") {
  Stage stage;
  stage.target.describe({{"gain", "%"}});
  stage.send({"/control/gain", {100.0 + 1e-5}});
  CHECK(stage.order().value == 1.0);
  CHECK(stage.take().empty());
}

TEST_CASE("osc host: what cannot be set is answered with an error", "[remote][osc]") {
  Stage stage;
  for (const auto& [message, names] :
       {std::pair{OscMessage{"/control/nothing", {1.0}}, "there is no control 'nothing'"},
        {OscMessage{"/control/fixed", {1.0}}, "fixed cannot be changed"},
        {OscMessage{"/control/hold", {}}, "hold: give a number in ms"},
        {OscMessage{"/control/hold", {std::string{"2 m"}}}, "hold: give"},
        {OscMessage{"/control/hold", {std::nan("")}}, "hold: give"},
        {OscMessage{"/control/hold", {std::monostate{}}}, "hold: give"},
        {OscMessage{"/control/x*", {1.0}}, "there is no control"},
        {OscMessage{"/trigger/nothing", {}}, "there is no control"},
        {OscMessage{"/trigger/fixed", {}}, "fixed cannot be changed"},
        {OscMessage{"/gesture/nothing", {1.0}}, "there is no gesture"},
        {OscMessage{"/gesture/strike", {}}, "strike: give a number"},
        {OscMessage{"/subscribe", {}}, "give /subscribe a pattern"},
        {OscMessage{"/subscribe", {std::string{"/nothing"}, 10.0}}, "nothing matches"},
        {OscMessage{"/nothing", {}}, "there is no message /nothing"}}) {
    CAPTURE(message.address);
    stage.send(message);
    CHECK(stage.error().find(names) != std::string::npos);
  }
  CHECK(stage.target.bundles.empty());
  stage.target.room = false;
  stage.send({"/control/hold", {20.0}});
  CHECK(stage.error().find("too many changes") != std::string::npos);
}

TEST_CASE("osc host: triggers, gestures and patterns", "[remote][osc]") {
  Stage stage;
  stage.send({"/trigger/strength"});
  CHECK(stage.order().kind == Kind::Trigger);
  stage.send({"/trigger/strength", {1.0}});
  CHECK(stage.order().kind == Kind::Trigger);
  stage.send({"/trigger/strength", {0.0}});  // a button is released
  CHECK(stage.target.bundles.empty());
  stage.send({"/trigger/strike"});
  CHECK(stage.order().kind == Kind::Strike);
  stage.send({"/gesture/strike", {0.5}});
  const auto gesture = stage.order();
  CHECK(gesture.kind == Kind::Gesture);
  CHECK(gesture.value == 0.5);
  stage.send({"/control/{strength,hold}", {1.0}});
  REQUIRE(stage.target.bundles.size() == 1);
  CHECK(stage.target.bundles[0].size() == 2);
}

TEST_CASE("osc host: a bundle keeps together and keeps its time, and none is more than 10 s ahead",
          "[remote][osc]") {
  Stage stage;
  stage.send_bundle({{"/control/strength", {0.5}}, {"/control/hold", {20.0}}}, stage.now_s() + 0.5);
  REQUIRE(stage.target.bundles.size() == 1);
  REQUIRE(stage.target.bundles[0].size() == 2);
  for (const auto& order : stage.target.bundles[0])
    CHECK(order.time_s == Approx(stage.now_s() + 0.5).margin(1e-6));
  stage.send_bundle({{"/control/strength", {0.5}}, {"/disarm", {}}}, stage.now_s() + 11);
  CHECK(stage.target.bundles.size() == 1);
  CHECK(stage.target.times_disarmed == 1);  // that is never put off
  CHECK(stage.error().find("10 s ahead") != std::string::npos);
}

TEST_CASE("osc host: disarm and mute work from anywhere, and unmuting where arming does", "[remote][osc]") {
  Stage stage;
  const auto elsewhere = peer(9, false);
  stage.target.is_armed = true;
  stage.send({"/disarm"}, elsewhere);
  CHECK_FALSE(stage.target.is_armed);
  stage.send({"/mute"}, elsewhere);
  CHECK(stage.target.is_muted);
  stage.send({"/mute", {std::int64_t{0}}}, elsewhere);
  CHECK(stage.target.is_muted);
  CHECK(stage.error(9).find("--osc-arm") != std::string::npos);
  stage.send({"/mute", {0.0}});
  CHECK_FALSE(stage.target.is_muted);
  for (const OscValue& value :
       {OscValue{std::int64_t{1}}, OscValue{std::string{"off"}}, OscValue{std::monostate{}}}) {
    stage.target.is_muted = false;
    stage.send({"/mute", {value}}, elsewhere);
    CHECK(stage.target.is_muted);
  }
}

TEST_CASE("osc host: disarm and mute work in a packet that is refused", "[remote][osc]") {
  Stage stage;
  const auto now = bytes("\0\0\0\0\0\0\0\1");
  const auto nested = [&](std::string packet) {
    for (int depth = 0; depth < 12; ++depth) packet = bundle_of(now, {packet});
    return packet;
  };
  const auto disarm = bytes("/disarm\0,\0\0\0"), mute = bytes("/mute\0\0\0,\0\0\0");
  const auto refused = [&](const std::string& packet) {
    const auto before = stage.host.counts().refused_packets;
    stage.target.is_armed = true, stage.target.is_muted = false;
    stage.host.receive(peer(1), packet, stage.now, stage.now_s());
    return stage.host.counts().refused_packets == before + 1;
  };
  CHECK(refused(nested(disarm)));
  CHECK_FALSE(stage.target.is_armed);
  CHECK(refused(nested(mute)));
  CHECK(stage.target.is_muted);
  CHECK(refused(bundle_of(now, {disarm, bytes("/x\0\0,b\0\0\1\0\0\0")})));
  CHECK_FALSE(stage.target.is_armed);
  CHECK(refused(nested(bytes("/unmute\0,\0\0\0"))));
  CHECK((stage.target.is_armed && !stage.target.is_muted));
}

TEST_CASE("osc host: the drives are armed by the number of the answer alone, within 3 s, once",
          "[remote][osc]") {
  Stage stage;
  const auto refused = [&](const std::vector<OscValue>& values, const OscPeer& from = peer(1)) {
    stage.send({"/arm", values}, from);
    CHECK(stage.error(from.port).find("not armed: ") == 0);
    CHECK(stage.target.arms == 0);
  };
  refused({});
  refused({std::int64_t{1}});
  auto number = stage.arm_number();
  refused({number + 1});
  refused({number});  // a wrong number has voided it
  number = stage.arm_number();
  refused({number}, peer(2));
  stage.pass(3010ms);
  refused({number});
  number = stage.arm_number();
  stage.target.disarm();  // by somebody else
  refused({number});
  number = stage.arm_number();
  stage.target.why_not_armed = "some reason";
  stage.send({"/arm", {number}});
  CHECK(stage.error() == "not armed: some reason");
  CHECK(stage.target.bundles.empty());
  stage.target.why_not_armed.clear();
  number = stage.arm_number();
  stage.send_bundle({{"/arm", {static_cast<double>(number)}}}, stage.now_s() + 5.0);
  const auto order = stage.order();
  CHECK(order.kind == Kind::Arm);
  CHECK(order.time_s == RemoteOrder::kNow);
  stage.target.arms = 0;
  refused({number});
}

TEST_CASE("osc host: only the client that armed keeps the drives armed, and learns of it", "[remote][osc]") {
  Stage stage;
  const auto number = stage.arm_number();
  stage.send({"/alive"});
  CHECK(stage.target.alives == 0);
  stage.send({"/arm", {number}});
  stage.target.is_armed = true;
  stage.pass(10ms);
  CHECK(stage.take().at(0).values == std::vector<OscValue>{std::int64_t{1}});
  stage.send({"/alive"}, peer(2));
  stage.send({"/alive"}, peer(1, false));
  stage.send({"/control/strength", {0.5}});
  CHECK(stage.target.alives == 0);
  stage.send({"/alive"});
  CHECK(stage.target.alives == 1);
  stage.target.is_armed = false;
  stage.pass(10ms);
  CHECK(stage.take().at(0).values == std::vector<OscValue>{std::int64_t{0}});
  stage.send({"/alive"});
  CHECK(stage.target.alives == 1);
}

TEST_CASE("osc host: an order to arm that has no room is void", "[remote][osc]") {
  Stage stage;
  const auto number = stage.arm_number();
  stage.target.room = false;
  stage.send({"/arm", {number}});
  CHECK(stage.target.times_disarmed == 1);
  CHECK(stage.error().find("not armed") == 0);
}

TEST_CASE("osc host: another host arms only with --osc-arm", "[remote][osc]") {
  const auto elsewhere = peer(1, false);
  Stage without;
  without.send({"/arm/request"}, elsewhere);
  CHECK(without.error().find("--osc-arm") != std::string::npos);
  without.send({"/arm", {std::int64_t{1}}}, elsewhere);
  CHECK(without.error().find("--osc-arm") != std::string::npos);
  Stage with{true};
  const auto number = with.arm_number(elsewhere);
  with.send({"/arm", {number}}, elsewhere);
  CHECK(with.target.arms == 1);
}

TEST_CASE("osc host: a reason of the control thread not to arm reaches the client", "[remote][osc]") {
  Stage stage;
  const auto number = stage.arm_number();
  stage.send({"/arm", {number}});
  RemoteEvent event;
  event.kind = RemoteEvent::Kind::NotArmed;
  std::copy_n("busy", 5, event.text);
  stage.target.events.push_back(event);
  stage.pass(10ms);
  CHECK(stage.error() == "not armed: busy");
}

TEST_CASE("osc host: a subscription sends what its pattern covers at its rate", "[remote][osc]") {
  Stage stage;
  stage.send({"/subscribe", {std::string{"/control"}, 20.0}});
  stage.pass(1000ms);
  const auto controls = stage.take();
  CHECK(controls.size() == Approx(20 * 4).margin(4));
  CHECK(controls[1].address == "/control/hold");
  CHECK(std::get<double>(controls[1].values[0]) == Approx(100.0));
  stage.send({"/unsubscribe"});
  stage.send({"/subscribe", {std::string{"/"}, 1e6}});  // 100 Hz are the most
  stage.pass(100ms);
  const auto all = stage.take();
  const auto value_of = [&](const std::string& address) {
    for (const auto& message : all)
      if (message.address == address) return std::get<double>(message.values[0]);
    return -1.0;
  };
  CHECK(all.size() == 10 * 12);
  CHECK(value_of("/level/in/mic") == 0.5);
  CHECK(value_of("/level/out/woofer") == 0.25);
  CHECK(value_of("/guard/woofer/ceiling") == 7.0);
  CHECK(value_of("/guard/woofer/soft_start") == 0.0);
  CHECK(value_of("/load") == 0.125);
  CHECK(value_of("/state/armed") == 0.0);
  CHECK(value_of("/state/late") == 3.0);
  stage.send({"/unsubscribe", {std::string{"/"}}});
  stage.pass(100ms);
  CHECK(stage.take().empty());
}

TEST_CASE("osc host: subscriptions follow an edit of the instrument", "[remote][osc]") {
  Stage stage;
  stage.send({"/subscribe", {std::string{"/control/*"}, 100.0}});
  stage.target.describe({{"other", ""}});
  stage.pass(10ms);
  const auto sent = stage.take();
  REQUIRE(sent.size() == 1);
  CHECK(sent[0].address == "/control/other");
}

TEST_CASE("osc host: a client that is silent for 10 s is forgotten", "[remote][osc]") {
  Stage stage;
  stage.send({"/subscribe", {std::string{"/load"}, 1.0}});
  stage.send({"/subscribe", {std::string{"/load"}, 1.0}}, peer(2));
  for (int second = 0; second < 15; ++second) {
    stage.pass(1s);
    stage.send({"/alive"});
  }
  CHECK(stage.take(1).size() == Approx(15).margin(1));
  CHECK(stage.take(2).size() == Approx(10).margin(1));
  CHECK(stage.host.clients() == 1);
}

TEST_CASE("osc host: events reach those who subscribed to them", "[remote][osc]") {
  Stage stage;
  stage.send({"/subscribe", {std::string{"/event/message"}}});
  stage.send({"/subscribe", {std::string{"/event"}}}, peer(2));
  stage.send({"/subscribe", {std::string{"/control"}, 1.0}}, peer(3));
  stage.pass(10ms);
  (void)stage.take(3);
  RemoteEvent event;
  event.frame = 4'000'000'000;
  std::copy_n("hello", 6, event.text);
  stage.target.events.push_back(event);
  event.kind = RemoteEvent::Kind::Muted;
  event.frame = 48;
  event.value = 1;
  stage.target.events.push_back(event);
  stage.pass(10ms);
  const auto first = stage.take(1);
  REQUIRE(first.size() == 1);
  CHECK(first[0].values == std::vector<OscValue>{std::int64_t{4'000'000'000}, "hello"});
  const auto second = stage.take(2);
  REQUIRE(second.size() == 2);
  CHECK(second[1].address == "/event/muted");
  CHECK(second[1].values == std::vector<OscValue>{std::int64_t{48}, std::int64_t{1}});
  CHECK(stage.take(3).empty());
}

TEST_CASE("osc host: an event of the instrument has an address of its own", "[remote][osc]") {
  Stage stage;
  stage.target.describe({{"strength", ""}}, {"hit", "toss"});
  stage.send({"/subscribe", {std::string{"/event/trigger/hit"}}});
  stage.send({"/subscribe", {std::string{"/event/trigger/*"}}}, peer(2));
  for (const auto* name : {"hit", "toss"}) {
    RemoteEvent event{.kind = RemoteEvent::Kind::Trigger, .level = 0.25, .frame = 4800};
    std::string{name}.copy(event.text, sizeof event.text - 1);
    stage.target.events.push_back(event);
  }
  stage.pass(10ms);
  const auto one = stage.take(1);
  REQUIRE(one.size() == 1);
  CHECK(one[0].address == "/event/trigger/hit");
  CHECK(one[0].values == std::vector<OscValue>{std::int64_t{4800}, 0.25});
  CHECK(stage.take(2).size() == 2);
}

TEST_CASE("osc host: an address without a meaning is learnt, and then moves its control over its range",
          "[remote][osc]") {
  Stage stage;
  stage.send({"/1/fader3", {0.5}});
  CHECK(stage.error() == "there is no message /1/fader3");
  stage.target.learning = true;
  stage.send({"/1/button", {std::string{"no number"}}});
  CHECK_FALSE(stage.error().empty());
  stage.send({"/1/fader3", {0.5}});
  CHECK(stage.target.learnt == "/1/fader3");
  CHECK(stage.take().empty());
  stage.target.learning = false;
  stage.target.describe({{"level", "dB"}});
  stage.pass(10ms);
  for (const double position : {0.0, 0.5, 7.0}) stage.send({"/1/fader3", {position}});
  REQUIRE(stage.target.bundles.size() == 3);
  CHECK(stage.target.bundles[0][0].value == Approx(0.001));
  CHECK(stage.target.bundles[1][0].value == Approx(0.0316227766));  // -30 dB of -60 to 0 dB
  CHECK(stage.target.bundles[2][0].value == 1.0);
  CHECK(stage.target.bundles[1][0].number == 10);
  stage.target.learning = true;  // for another control: it moves the first one no more
  stage.target.learnt.clear();
  stage.send({"/1/fader3", {0.25}});
  CHECK(stage.target.learnt == "/1/fader3");
  CHECK(stage.target.bundles.size() == 3);
}

TEST_CASE("osc host: the list has every control with its unit and range", "[remote][osc]") {
  Stage stage;
  stage.send({"/list"});
  const auto list = stage.take();
  REQUIRE(list.size() == 5);
  CHECK(list[1].values == std::vector<OscValue>{"hold", 100.0, 2.0, 100.0, "ms", std::int64_t{0}});
  CHECK(std::get<double>(list[2].values[2]) == Approx(-60.0));
  CHECK(list[4].address == "/list/end");
}

TEST_CASE("osc host: clients, subscriptions and answers are bounded", "[remote][osc]") {
  Stage stage;
  for (std::uint16_t port = 1; port <= 100; ++port) {
    stage.send({"/subscribe", {std::string{"/load"}, 1.0}}, peer(port));
    for (int n = 0; n < 30; ++n)
      stage.send({"/subscribe", {"/load" + std::string(static_cast<std::size_t>(n), '*'), 1.0}}, peer(port));
  }
  CHECK(stage.host.clients() == OscHost::kMostClients);
  const auto sent = stage.host.counts().answers;
  CHECK(sent <= OscHost::kMostAnswers);
  CHECK(stage.host.counts().lost_answers > 0);
  stage.pass(10ms);
  CHECK(stage.host.counts().answers - sent <= static_cast<std::int64_t>(OscHost::kMostClients * 16));
}

TEST_CASE("osc host: the description of OSCQuery has units, ranges and values", "[remote][osc]") {
  test::FakeRemoteTarget target;
  const auto get = [&](const std::string& path) { return osc_query(target, path, 9000); };
  CHECK(get("/control/hold?VALUE").body == "{\n \"VALUE\": [\n  100.0\n ]\n}");
  CHECK(get("/control/hold?UNIT").body.find("\"ms\"") != std::string::npos);
  CHECK(get("/control/hold").body.find("\"MIN\": 2.0") != std::string::npos);
  CHECK(get("/control/fixed").body.find("\"ACCESS\": 1") != std::string::npos);
  CHECK(get("/?HOST_INFO").body.find("\"OSC_PORT\": 9000") != std::string::npos);
  CHECK(get("/").body.find("/level/in/mic") != std::string::npos);
  CHECK(get("/nothing").status == 404);
  CHECK(get("/control/hold?NOTHING").status == 204);
  CHECK(answer_http(target, "GET /control/hold HTTP/1.1\r\nHost: x\r\n\r\n", 9000).status == 200);
  CHECK(answer_http(target, "POST / HTTP/1.1\r\n\r\n", 9000).status == 405);
  CHECK(answer_http(target, "GET /\r\n\r\n", 9000).status == 400);
  CHECK(answer_http(target, "", 9000).status == 405);
}

// TACTUS_OSC_PACKETS: how many; scripts/nightly has a million.
TEST_CASE("osc host: random and mutated packets crash nothing and move nothing beyond its range",
          "[remote][osc][osc-fuzz]") {
  const char* wanted = std::getenv("TACTUS_OSC_PACKETS");
  const long packets = wanted != nullptr ? std::atol(wanted) : 100'000;
  Stage stage{true};
  std::vector<std::string> seeds;
  const auto seed = [&](const std::vector<OscMessage>& messages, double time_s = OscBundle::kNow) {
    for (auto& packet : build_osc(messages, time_s)) seeds.push_back(std::move(packet));
  };
  for (const auto* address :
       {"/control/strength", "/control/{hold,level}", "/control/*", "/trigger/hold", "/gesture/strike",
        "/arm", "/arm/request", "/disarm", "/mute", "/alive", "/unsubscribe", "/list"})
    seed({{address, {0.5, 0.25}}});
  seed({{"/subscribe", {std::string{"/level/*"}, 100.0}}});
  seed({{"/control/hold", {std::string{"20 ms"}, std::string{"1 s"}}}});
  seed({{"/control/hold", {20.0}}, {"/control/strength", {0.1, 2.0}}, {"/mute", {std::int64_t{1}}}},
       stage.now_s() + 1.0);
  std::mt19937 random{20261126};
  const auto below = [&](std::size_t end) {
    return std::uniform_int_distribution<std::size_t>{0, end - 1}(random);
  };
  long bad = 0;
  for (long n = 0; n < packets; ++n) {
    std::string packet = seeds[below(seeds.size())];
    if (below(10) == 0) packet.resize(4 * below(64));
    for (auto changes = below(6); changes > 0 && !packet.empty(); --changes) {
      const auto at = below(packet.size());
      switch (below(5)) {
        case 0:
          packet[at] = static_cast<char>(below(256));
          break;
        case 1:
          packet[at] = static_cast<char>(packet[at] ^ (1 << below(8)));
          break;
        case 2:
          packet.insert(at / 4 * 4, packet.substr(at / 4 * 4, 4 * (1 + below(8))));
          break;
        case 3:
          packet.erase(at / 4 * 4, 4 * (1 + below(4)));
          break;
        default:
          packet[at] = "*?[]{}/,#ifsdhTFb\0\xff"[below(19)];
      }
    }
    stage.host.receive(peer(static_cast<std::uint16_t>(1 + below(200))), packet, stage.now, stage.now_s());
    if (n % 100 == 0) stage.pass(10ms);
    for (const auto& bundle : stage.target.bundles)
      for (const auto& order : bundle) {
        if (order.kind == Kind::Set) {
          const auto& control =
              stage.target.description()->controls.at(static_cast<std::size_t>(order.number - 10));
          bad += !(order.value >= control.low && order.value <= control.high) || control.constant ||
                 !(order.ramp_s >= 0 && order.ramp_s <= OscHost::kMostRamp_s);
        }
        bad += order.time_s > stage.now_s() + OscHost::kMostAhead_s;
      }
    stage.target.bundles.clear();
    stage.received.clear();
  }
  CHECK(bad == 0);
  CHECK(stage.host.counts().packets == packets);
  CHECK(stage.host.counts().refused_packets > packets / 10);
  CHECK(stage.host.counts().orders > packets / 100);
  CHECK(stage.host.clients() <= OscHost::kMostClients);
}
