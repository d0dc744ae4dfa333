#include "remote/panel/panel_host.h"

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <random>

#include "tests/remote/fake_remote_target.h"

using namespace tactus;
using namespace std::chrono_literals;
using Json = nlohmann::json;

namespace {

/// With a scope.
class Target final : public test::FakeRemoteTarget {
 public:
  void order_scope(std::uint32_t id, int bin, std::vector<std::string> signals) override {
    scope_id = id;
    scope_bin = bin;
    scope_signals = std::move(signals);
  }
  void order_levels(bool on) override { levels = on; }
  void watch_bodies(RemoteWatch watch) override { watched = watch; }
  std::shared_ptr<const RemoteBodies> bodies() const override { return last_bodies; }
  bool take_scope(ScopeChunk& chunk) override {
    if (chunks.empty()) return false;
    chunk = chunks.front();
    chunks.pop_front();
    return true;
  }
  std::shared_ptr<const RemoteEdit> edit() const override { return last_edit; }
  std::shared_ptr<const RemoteVerdict> verdict() const override { return last_verdict; }
  void order_verdict(double delay_s) override { delay_to_judge = delay_s; }

  std::uint32_t scope_id = 0;
  int scope_bin = 0;
  std::vector<std::string> scope_signals;
  bool levels = false;
  RemoteWatch watched;
  std::shared_ptr<const RemoteBodies> last_bodies;
  std::deque<ScopeChunk> chunks;
  std::shared_ptr<const RemoteEdit> last_edit;
  std::shared_ptr<const RemoteVerdict> last_verdict;
  double delay_to_judge = 0;
};

struct Stage {
  explicit Stage(bool arm_from_elsewhere = false) : host{target, sender(), arm_from_elsewhere} { tick(); }

  PanelHost::Sender sender() {
    return {[this](int client, const std::string& text) { texts[client].push_back(Json::parse(text)); },
            [this](int client, const std::string& bytes) { scopes[client].push_back(bytes); }};
  }
  void connect(int client, bool local = true) { host.connected(client, local); }
  void send(int client, const Json& json) { host.received(client, json.dump(), now); }
  void tick(std::chrono::milliseconds passed = 10ms) {
    now += passed;
    host.tick(now);
  }
  /// The last message of a kind to a client.
  Json last(int client, const std::string& kind) {
    auto& all = texts[client];
    for (auto message = all.rbegin(); message != all.rend(); ++message)
      if ((*message)["kind"] == kind) return *message;
    return {};
  }
  std::string error(int client) {
    const auto answer = last(client, "answer");
    return answer.contains("error") ? answer["error"].get<std::string>() : "";
  }
  /// Requests a number and arms with it. False: no number was given.
  bool arm(int client) {
    send(client, {{"do", "arm_request"}});
    const auto answer = last(client, "answer");
    if (!answer.contains("number")) return false;
    send(client, {{"do", "arm"}, {"number", answer["number"]}});
    return true;
  }

  Target target;
  std::map<int, std::vector<Json>> texts;
  std::map<int, std::vector<std::string>> scopes;
  PanelHost::Clock::time_point now{1h};
  PanelHost host;
};

}  // namespace

TEST_CASE("panel host: a browser first gets the description", "[remote][panel]") {
  Stage stage;
  stage.connect(1);
  REQUIRE(stage.texts[1].size() == 1);
  const auto& description = stage.texts[1].front();
  CHECK(description["kind"] == "description");
  CHECK(description["protocol"] == 1);
  CHECK(description["controls"][1]["name"] == "hold");
  CHECK(description["controls"][1]["unit"] == "ms");
  CHECK(description["controls"][1]["low"].get<double>() == Approx(2.0));
  CHECK(description["controls"][1]["high"].get<double>() == Approx(100.0));
  CHECK(description["controls"][3]["constant"] == true);
  CHECK(description["gestures"][0]["name"] == "strike");
  stage.target.describe({{"other", ""}});
  stage.tick();
  CHECK(stage.last(1, "description")["controls"].size() == 1);
}

TEST_CASE("panel host: controls are set in their own unit, within their range", "[remote][panel]") {
  Stage stage;
  stage.connect(1);
  stage.send(1, {{"do", "set"}, {"name", "hold"}, {"value", 20}});
  stage.send(1, {{"do", "set"}, {"name", "hold"}, {"value", 1e9}, {"ramp", 0.5}});
  stage.send(1, {{"do", "set"}, {"name", "level"}, {"value", -20}});
  REQUIRE(stage.target.bundles.size() == 3);
  CHECK(stage.target.bundles[0][0].value == Approx(0.02));
  CHECK(stage.target.bundles[1][0].value == Approx(0.1));
  CHECK(stage.target.bundles[1][0].ramp_s == 0.5);
  CHECK(stage.target.bundles[2][0].value == Approx(0.1));
  CHECK(stage.error(1).empty());

  for (const auto& [order, error] : std::vector<std::pair<Json, std::string>>{
           {{{"do", "set"}, {"name", "x"}, {"value", 1}}, "there is no control 'x'"},
           {{{"do", "set"}, {"name", "hold"}, {"value", "20"}}, "hold: give a number"},
           {{{"do", "set"}, {"name", "hold"}}, "hold: give a number"},
           {{{"do", "set"}, {"name", "hold"}, {"value", 2}, {"ramp", -1}}, "hold: a ramp takes 0 to 3600 s"},
           {{{"do", "set"}, {"name", "fixed"}, {"value", 0.5}}, "fixed cannot be changed during playback"},
           {{{"do", "jump"}}, "this is no order"},
           {Json::array(), "this is no order"},
           {{{"do", 7}}, "this is no order"}}) {
    stage.send(1, order);
    CHECK(stage.error(1) == error);
  }
  CHECK(stage.target.bundles.size() == 3);
  stage.target.room = false;
  stage.send(1, {{"do", "trigger"}, {"name", "strength"}});
  CHECK(stage.error(1) == "too many changes wait: this one is dropped");
}

TEST_CASE("panel host: triggers and gestures", "[remote][panel]") {
  Stage stage;
  stage.connect(1);
  stage.send(1, {{"do", "trigger"}, {"name", "strength"}});
  stage.send(1, {{"do", "trigger"}, {"name", "strike"}});
  stage.send(1, {{"do", "gesture"}, {"name", "strike"}, {"value", 0.25}});
  REQUIRE(stage.target.bundles.size() == 3);
  CHECK(stage.target.bundles[0][0].kind == RemoteOrder::Kind::Trigger);
  CHECK(stage.target.bundles[1][0].kind == RemoteOrder::Kind::Strike);
  CHECK(stage.target.bundles[2][0].kind == RemoteOrder::Kind::Gesture);
  CHECK(stage.target.bundles[2][0].value == 0.25);
}

TEST_CASE("panel host: arming needs the number of a request that is at most 3 s old, once",
          "[remote][panel]") {
  Stage stage;
  stage.connect(1);
  stage.connect(2);
  stage.send(1, {{"do", "arm"}, {"number", 1}});
  CHECK(stage.target.arms == 0);
  stage.send(1, {{"do", "arm_request"}});
  const auto number = stage.last(1, "answer")["number"];
  stage.send(2, {{"do", "arm"}, {"number", number}});  // of another client
  stage.send(1, {{"do", "arm"}, {"number", number.get<std::int64_t>() + 1}});
  stage.send(1, {{"do", "arm"}, {"number", number}});  // void by then
  CHECK(stage.target.arms == 0);
  stage.send(1, {{"do", "arm_request"}});
  stage.tick(3001ms);
  stage.send(1, {{"do", "arm"}, {"number", stage.last(1, "answer")["number"]}});
  CHECK(stage.target.arms == 0);
  CHECK(stage.error(1).find("not armed: the request is older than 3 s") == 0);
  stage.send(1, {{"do", "arm_request"}});
  stage.target.disarm();  // by somebody else
  stage.send(1, {{"do", "arm"}, {"number", stage.last(1, "answer")["number"]}});
  CHECK(stage.target.arms == 0);
  CHECK(stage.error(1).find("not armed: the drives were disarmed after the request") == 0);
  CHECK(stage.arm(1));
  CHECK(stage.target.arms == 1);
  CHECK(stage.target.bundles.back()[0].kind == RemoteOrder::Kind::Arm);
}

TEST_CASE("panel host: only the client that armed keeps the drives armed, and they go with it",
          "[remote][panel]") {
  Stage stage;
  stage.connect(1);
  stage.connect(2);
  REQUIRE(stage.arm(1));
  stage.target.is_armed = true;
  stage.tick(60ms);
  CHECK(stage.last(1, "state")["owner"] == true);
  CHECK(stage.last(2, "state")["owner"] == false);
  stage.send(2, {{"do", "alive"}});
  CHECK(stage.target.alives == 0);
  stage.send(1, {{"do", "alive"}});
  CHECK(stage.target.alives == 1);
  stage.host.disconnected(2);
  CHECK(stage.target.times_disarmed == 0);
  stage.host.disconnected(1);
  CHECK(stage.target.times_disarmed == 1);
}

TEST_CASE("panel host: a client whose drives were disarmed is no longer the owner", "[remote][panel]") {
  Stage stage;
  stage.connect(1);
  REQUIRE(stage.arm(1));
  stage.target.is_armed = true;
  stage.tick();
  stage.target.is_armed = false;  // by a key
  stage.tick();
  stage.target.is_armed = true;  // by somebody else
  stage.tick(60ms);
  CHECK(stage.last(1, "state")["owner"] == false);
  stage.send(1, {{"do", "alive"}});
  CHECK(stage.target.alives == 0);
  stage.host.disconnected(1);
  CHECK(stage.target.times_disarmed == 0);
}

TEST_CASE("panel host: arming needs a request", "[remote][panel]") {
  Stage stage;
  stage.connect(1);
  stage.send(1, {{"do", "arm"}, {"number", 5}});
  CHECK(stage.error(1).find("not armed: no number was requested; request") == 0);
  CHECK(stage.host.counts().refused == 1);
  CHECK(stage.target.arms == 0);
}

TEST_CASE("panel host: a client whose order to arm was refused is no owner", "[remote][panel]") {
  Stage stage;
  stage.connect(1);
  REQUIRE(stage.arm(1));
  RemoteEvent event{.kind = RemoteEvent::Kind::NotArmed};
  std::string{"another program writes to it"}.copy(event.text, sizeof event.text - 1);
  stage.target.events = {event};
  stage.tick();
  CHECK(stage.error(1) == "not armed: another program writes to it");
  stage.target.is_armed = true;  // by a key
  stage.tick(60ms);
  CHECK(stage.last(1, "state")["owner"] == false);
  stage.host.disconnected(1);
  CHECK(stage.target.times_disarmed == 0);
}

TEST_CASE("panel host: another host arms and unmutes only with --panel-arm, and always mutes and disarms",
          "[remote][panel]") {
  Stage without, with{true};
  for (auto* stage : {&without, &with}) {
    stage->connect(1, /*local=*/false);
    stage->send(1, {{"do", "mute"}});
    CHECK(stage->target.is_muted);
    stage->send(1, {{"do", "disarm"}});
    CHECK(stage->target.times_disarmed == 1);
  }
  CHECK_FALSE(without.arm(1));
  CHECK(without.error(1) == "arming from another host needs --panel-arm");
  without.send(1, {{"do", "mute"}, {"on", false}});
  CHECK(without.target.is_muted);
  CHECK(with.arm(1));
  CHECK(with.target.arms == 1);
  with.send(1, {{"do", "mute"}, {"on", false}});
  CHECK_FALSE(with.target.is_muted);
}

TEST_CASE("panel host: of too many messages only those that stop the drives are obeyed", "[remote][panel]") {
  Stage stage;
  stage.connect(1);
  for (int i = 0; i < 1000; ++i) stage.send(1, {{"do", "set"}, {"name", "strength"}, {"value", 0.5}});
  CHECK(stage.target.bundles.size() == PanelHost::kMostMessages);
  CHECK(stage.host.counts().refused == 1000 - PanelHost::kMostMessages);
  stage.send(1, {{"do", "disarm"}});
  stage.send(1, {{"do", "mute"}});
  CHECK(stage.target.times_disarmed == 1);
  CHECK(stage.target.is_muted);
  stage.send(1, {{"do", "set"}, {"name", "strength"}, {"value", 0.5}});
  CHECK(stage.target.bundles.size() == PanelHost::kMostMessages);
  stage.tick(100ms);
  stage.send(1, {{"do", "set"}, {"name", "strength"}, {"value", 0.5}});
  CHECK(stage.target.bundles.size() == PanelHost::kMostMessages + 1);
}

TEST_CASE("panel host: the state has the levels, and what the guard did", "[remote][panel]") {
  Stage stage;
  stage.connect(1);
  stage.tick(60ms);
  const auto state = stage.last(1, "state");
  CHECK(state["inputs"] == Json::array({0.5}));
  CHECK(state["outputs"] == Json::array({0.25}));
  CHECK(state["guard"] == Json::array({Json::array({7.0, 0.0})}));
  CHECK(state["controls"].size() == 4);
  CHECK(state["controls"][1].get<double>() == Approx(100.0));
  CHECK_FALSE(state.contains("levels"));
  CHECK(stage.target.levels == false);
  stage.send(1, {{"do", "levels"}, {"on", true}});
  CHECK(stage.target.levels == true);
  stage.host.disconnected(1);
  CHECK(stage.target.levels == false);
}

TEST_CASE("panel host: bodies go to the browsers that asked, and nothing is said without a world",
          "[remote][panel]") {
  Stage stage;
  stage.connect(1);
  CHECK_FALSE(stage.last(1, "description").contains("worlds"));
  stage.send(1, {{"do", "bodies"}});
  CHECK(stage.error(1) == "there are no rigid bodies");
  CHECK_FALSE(stage.target.watched.poses);
  stage.target.worlds = {{"hall", {{{"ball", "sphere", 1}, {"block", "box", 2}}, {"hand"}}}};
  stage.target.describe({{"strength", ""}});
  stage.tick();
  CHECK(stage.last(1, "description")["worlds"][0]["bodies"][1]["name"] == "block");
  stage.connect(2);
  stage.send(2, {{"do", "bodies"}, {"on", true}});
  CHECK(stage.target.watched == RemoteWatch{.poses = true});
  BodyPoses poses{0, std::vector<BodyPose>(2), {{1, {0.5, 0, 0}, {}}}};
  poses.bodies[0].present = false;
  poses.bodies[1].position = {1, -2, 1.0 / 3};
  poses.bodies[1].size = {0.1, 0.2, 0.3};
  stage.target.last_bodies = std::make_shared<RemoteBodies>(RemoteBodies{{poses}});
  stage.tick(60ms);
  CHECK_FALSE(stage.last(1, "state").contains("bodies"));
  const auto bodies = stage.last(2, "state")["bodies"][0];
  CHECK(bodies["bodies"][0].is_null());
  CHECK(bodies["bodies"][1] == Json{1.0, -2.0, 0.333333, 1.0, 0.0, 0.0, 0.0, 0.1, 0.2, 0.3});
  CHECK(bodies["handles"] == Json::array({{0.5, 0.0, 0.0, 1}}));
  stage.host.disconnected(2);
  CHECK_FALSE(stage.target.watched.poses);
}

TEST_CASE("panel host: events and errors of edits reach every browser", "[remote][panel]") {
  Stage stage;
  stage.connect(1);
  stage.connect(2);
  RemoteEvent event{.kind = RemoteEvent::Kind::Guard, .frame = 480};
  std::string{"woofer faded"}.copy(event.text, sizeof event.text - 1);
  stage.target.events = {event};
  stage.target.last_edit = std::make_shared<RemoteEdit>(RemoteEdit{
      {{Errc::Syntax, "a:b.toml:3:7", "no such port", "write in"}, {Errc::Syntax, "x.toml", "y", ""}}});
  stage.tick();
  for (const int client : {1, 2}) {
    CHECK(stage.last(client, "event")["what"] == "guard");
    CHECK(stage.last(client, "event")["text"] == "woofer faded");
    CHECK(stage.last(client, "event")["frame"] == 480);
    const auto errors = stage.last(client, "edit")["errors"];
    CHECK(errors[0]["file"] == "a:b.toml");
    CHECK(errors[0]["line"] == 3);
    CHECK(errors[0]["column"] == 7);
    CHECK(errors[0]["remedy"] == "write in");
    CHECK(errors[1]["file"] == "x.toml");
    CHECK(errors[1]["line"] == 0);
  }
  stage.connect(3);
  CHECK(stage.last(3, "edit")["errors"].size() == 2);
}

TEST_CASE("panel host: an event of the instrument has its name and level", "[remote][panel]") {
  Stage stage;
  stage.connect(1);
  stage.target.describe({{"strength", ""}}, {"hit"});
  stage.tick();
  CHECK(stage.last(1, "description")["events"] == Json::array({"hit"}));
  RemoteEvent event{.kind = RemoteEvent::Kind::Trigger, .level = 0.25, .frame = 480};
  std::string{"hit"}.copy(event.text, sizeof event.text - 1);
  stage.target.events = {event};
  stage.tick();
  CHECK(stage.last(1, "event")["what"] == "trigger");
  CHECK(stage.last(1, "event")["text"] == "hit");
  CHECK(stage.last(1, "event")["value"] == 0.25);
}

TEST_CASE("panel host: asks whether the world is stable with another delay", "[remote][panel]") {
  Stage stage;
  stage.connect(1);
  CHECK_FALSE(stage.last(1, "description").contains("delay"));
  stage.send(1, {{"do", "delay"}, {"seconds", 0.005}});
  CHECK(stage.error(1) == "there is no simulated world");
  stage.target.world_delay = 0.02;
  stage.target.describe({{"strength", ""}});
  stage.tick();
  CHECK(stage.last(1, "description")["delay"] == 0.02);
  stage.send(1, {{"do", "delay"}, {"seconds", 2}});
  CHECK(stage.error(1) == "a delay takes 0 to 1 s");
  stage.send(1, {{"do", "delay"}, {"seconds", 0.005}});
  CHECK(stage.target.delay_to_judge == 0.005);
  stage.target.last_verdict = std::make_shared<RemoteVerdict>(RemoteVerdict{0.005, true, "stable"});
  stage.tick();
  CHECK(stage.last(1, "verdict")["delay"] == 0.005);
  CHECK(stage.last(1, "verdict")["stable"] == true);
  CHECK(stage.last(1, "verdict")["text"] == "stable");
}

TEST_CASE("panel host: the last client that asks has the scope", "[remote][panel]") {
  Stage stage;
  stage.connect(1);
  stage.connect(2);
  Json many = Json::array();
  for (int i = 0; i < 20; ++i) many.push_back("s" + std::to_string(i));
  stage.send(1, {{"do", "scope"}, {"id", 3}, {"signals", many}, {"bin", 10}});
  CHECK(stage.target.scope_id == 3);
  CHECK(stage.target.scope_bin == 10);
  CHECK(stage.target.scope_signals.size() == ScopeChunk::kMostTraces);
  ScopeChunk chunk;
  chunk.id = 3;
  chunk.bin = 10;
  chunk.traces = 1;
  chunk.bins = 2;
  chunk.frame = 960;
  chunk.values = {-1.0F, 1.0F, -0.5F, 0.5F};
  stage.target.chunks = {chunk};
  stage.tick();
  REQUIRE(stage.scopes[1].size() == 1);
  CHECK(stage.scopes[1][0].size() == 24 + 4 * sizeof(float));
  double frame = 0;
  std::memcpy(&frame, stage.scopes[1][0].data() + 16, sizeof frame);
  CHECK(frame == 960);
  float last = 0;
  std::memcpy(&last, stage.scopes[1][0].data() + 24 + 12, sizeof last);
  CHECK(last == 0.5F);

  stage.send(2, {{"do", "scope"}, {"id", 4}, {"signals", {"a"}}, {"bin", -5}});
  CHECK(stage.error(1) == "another panel has taken the scope");
  CHECK(stage.target.scope_bin == 1);
  stage.target.chunks = {chunk};
  stage.tick();
  CHECK(stage.scopes[1].size() == 1);
  CHECK(stage.scopes[2].size() == 1);
  stage.host.disconnected(2);
  CHECK(stage.target.scope_signals.empty());
}

// TACTUS_PANEL_MESSAGES: how many; scripts/nightly has a million.
TEST_CASE("panel host: random and mutated messages move nothing beyond its range",
          "[remote][panel][panel-fuzz]") {
  const char* wanted = std::getenv("TACTUS_PANEL_MESSAGES");
  const int messages = wanted != nullptr ? std::stoi(wanted) : 20'000;
  std::mt19937 random{11};
  const auto below = [&](std::size_t end) { return random() % end; };
  const std::vector<std::string> good = {
      R"({"do":"set","name":"hold","value":20,"ramp":0.5})",
      R"({"do":"trigger","name":"strike"})",
      R"({"do":"gesture","name":"strike","value":0.3})",
      R"({"do":"arm_request"})",
      R"({"do":"arm","number":12345})",
      R"({"do":"alive"})",
      R"({"do":"mute","on":true})",
      R"({"do":"scope","id":3,"signals":["a","b"],"bin":1})",
      R"({"do":"levels","on":true})",
      R"({"do":"bodies","on":true})",
      R"({"do":"set","name":"level","value":-1e308})",
      R"([[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[{"do":"disarm"}]]]]]]]]]]]]]]]]]]]]]]]]]]]]]]]])"};
  Stage stage;
  for (int m = 0; m < messages; ++m) {
    auto text = good[below(good.size())];
    for (auto changes = below(6); changes > 0; --changes) {
      const auto at = below(text.size() + 1);
      if (below(3) == 0)
        text.insert(at, 1, static_cast<char>(random()));
      else if (at < text.size() && below(2) == 0)
        text.erase(at, 1 + below(4));
      else if (at < text.size())
        text[at] = static_cast<char>(random());
    }
    if (below(500) == 0) text.assign(below(10'000), static_cast<char>(random()));
    if (m % 100 == 0) {
      stage.host.disconnected(1);
      stage.connect(1, below(2) == 0);
      stage.tick(100ms);
      stage.texts.clear();
    }
    stage.host.received(1, text, stage.now);
  }
  for (const auto& bundle : stage.target.bundles)
    for (const auto& order : bundle) {
      CHECK(order.ramp_s >= 0);
      if (order.kind != RemoteOrder::Kind::Set) continue;
      const auto& control =
          stage.target.description()->controls.at(static_cast<std::size_t>(order.number - 10));
      CHECK(order.value >= control.low);
      CHECK(order.value <= control.high);
    }
  CHECK(stage.target.arms == 0);
  CHECK(stage.host.counts().messages >= messages);
}
