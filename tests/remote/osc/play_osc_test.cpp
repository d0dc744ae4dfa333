// A session and the program itself, on a simulated card, with OSC clients.
#include <sys/socket.h>

#include <algorithm>
#include <atomic>
#include <catch2/catch.hpp>
#include <cmath>
#include <csignal>
#include <string>
#include <thread>
#include <vector>

#include "apps/cli/stop_loop.h"
#include "apps/play/live/remote/live_remote.h"
#include "backends/loop/loop.h"
#include "backends/take/take.h"
#include "backends/wav_file.h"
#include "remote/osc/osc_server.h"
#include "tests/remote/osc/osc_client.h"
#include "tests/support/child_process.h"
#include "tests/support/desk.h"
#include "tests/support/keyboard.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/wait_until.h"

using namespace tactus;
using namespace tactus::app;
using namespace std::chrono_literals;
using test::wait_until;

namespace {

const std::string kTone = R"(format = 1
name = "tone"
[controls]
level = { value = 0.1, range = [0, 0.12], smooth = "0 ms" }
gain = { value = "-6 dB", range = ["-60 dB", "0 dB"] }
time = { value = "20 ms", range = ["1 ms", "100 ms"] }
start = { value = 0, range = [0, 1], smooth = "0 ms" }
[nodes]
bump = { type = "decay", trigger = "start", time = "time" }
[outputs]
tone = { from = "level" }
other = { from = "0.01 * gain * bump" }
)";

/// A session with a server; nothing of it moves on but what runs on threads of its own, unless the test says.
struct Stage {
  explicit Stage(bool armed = false)
      : performer{make_instrument({resolve_target(folder.write("tone.toml", kTone).string())})},
        session{*performer, backend, request(), armed, &dead_man} {
    REQUIRE(server);
    REQUIRE(session.open(wav));
    REQUIRE(session.start());
  }
  static StreamRequest request() {
    StreamRequest request;
    request.sample_rate = 48_kHz;
    request.out_channels = 2;
    return request;
  }
  /// What the control loop does.
  void tick() {
    (void)loop.wait_key(0ms);
    remote.tick();
    session.tick();
    for (auto& message : remote.take_messages()) messages.push_back(std::move(message));
    for (auto& message : session.take_messages()) messages.push_back(std::move(message));
  }
  bool tick_until(const std::function<bool()>& holds) {
    return wait_until([&] { return tick(), holds(); });
  }
  bool says(const std::string& text) const {
    return std::ranges::any_of(messages, [&](const auto& m) { return m.find(text) != std::string::npos; });
  }
  /// Asked without the control loop.
  bool silent() {
    const auto before = session.view().health.blocks;
    double highest = 0.0;
    REQUIRE(wait_until([&] {
      const auto& view = session.view();
      highest = std::max(highest, view.outputs[0].peak);
      return view.health.blocks >= before + 10;
    }));
    return highest == 0.0;
  }
  void arm(test::OscClient& client) {
    client.send({"/arm/request"});
    const auto number = client.wait_for("/arm/number");
    REQUIRE(number);
    client.send({"/arm", number->values});
    REQUIRE(tick_until([&] { return session.armed(); }));
  }

  test::TemporaryFolder folder;
  std::filesystem::path wav = folder.path() / "take.wav";
  const test::Keyboard keyboard;
  LoopBackend backend;
  DeadMansSwitch dead_man;
  std::unique_ptr<Performer> performer;
  Session session;
  LiveRemote remote{session, *performer, 48_kHz};
  Result<std::unique_ptr<OscServer>> server = OscServer::open({}, remote);
  StopLoop loop{dead_man,
                {.act = {},
                 .each_turn = [this](auto now) { remote.watch(now); },
                 .inputs = {},
                 .control_stalled = {},
                 .fade = session.closing_time()}};
  std::vector<std::string> messages;
};

/// `tactus play` with OSC at a free port.
struct Program {
  explicit Program(const test::Desk& desk, const std::vector<std::string>& more = {}) {
    const auto tone = desk.folder.write("tone.toml", kTone).string();
    std::vector<std::string> command = {
        "sh",    "-c", "exec \"$0\" \"$@\" </dev/null", TACTUS_PROGRAM, "play", tone, "--backend", "loop",
        "--osc", "0"};
    command.insert(command.end(), more.begin(), more.end());
    process.emplace(command, test::ChildProcess::Stdout::Logged);
    REQUIRE(wait_until([&] { return log().find("OSC       udp 127.0.0.1:") != std::string::npos; }));
    const auto text = log();
    port = std::stoi(text.substr(text.find("udp 127.0.0.1:") + 14));
  }
  std::string log() const { return process->log(); }
  int stop() {
    process->send(SIGTERM);
    return process->wait(60s).value_or(-1);
  }

  std::optional<test::ChildProcess> process;
  int port = 0;
};

/// Of a control of the take.
std::vector<JournalEntry> changes(const Take& take, const std::string& control) {
  std::vector<JournalEntry> found;
  const auto& names = take.header.controls;
  const auto index = static_cast<int>(std::ranges::find(names, control) - names.begin());
  for (const auto& entry : take.engine)
    if ((entry.kind == JournalEntry::Kind::ControlChange || entry.kind == JournalEntry::Kind::ControlSet) &&
        entry.index == index)
      found.push_back(entry);
  return found;
}

}  // namespace

TEST_CASE("live osc: /disarm and /mute fade the drives while the control loop is blocked", "[remote][live]") {
  Stage stage{true};
  REQUIRE(wait_until([&] { return stage.session.view().outputs[0].peak == Approx(0.1); }));
  const test::OscClient client{(*stage.server)->port()};
  const std::string order = GENERATE(as<std::string>{}, "/disarm", "/mute");
  CAPTURE(order);
  client.send({order});
  CHECK(wait_until([&] { return stage.silent(); }));
  stage.tick();
  CHECK(stage.says(order == "/disarm" ? "drives disarmed by a remote client" : "muted by a remote client"));
}

TEST_CASE(
    "live osc: drives that a client armed fade 500 ms after its last /alive, also while the control "
    "loop is blocked",
    "[remote][live]") {
  Stage stage;
  test::OscClient client{(*stage.server)->port()};
  stage.arm(client);
  auto last = std::chrono::steady_clock::now();
  const auto until = last + 1s;
  REQUIRE(stage.tick_until([&] {
    client.send({"/alive"});
    last = std::chrono::steady_clock::now();
    return last > until && stage.session.view().outputs[0].peak == Approx(0.1);
  }));
  CHECK(stage.session.armed());
  REQUIRE(wait_until([&] { return !stage.session.armed(); }));
  const auto passed = std::chrono::steady_clock::now() - last;
  CHECK(passed >= 495ms);  // the packet was on its way
  CHECK(wait_until([&] { return stage.silent(); }));
  stage.tick();
  CHECK(stage.says("the remote client that had armed them was silent"));
  CHECK(client.wait_for("/armed")->values == std::vector<OscValue>{std::int64_t{1}});
  CHECK(client.wait_for("/armed")->values == std::vector<OscValue>{std::int64_t{0}});
}

TEST_CASE("live osc: drives that were disarmed and armed at the keyboard need no client", "[remote][live]") {
  Stage stage;
  test::OscClient client{(*stage.server)->port()};
  stage.arm(client);
  stage.session.switches().disarm();
  stage.session.switches().order_arm();
  REQUIRE(stage.session.arm(true));
  const auto begin = std::chrono::steady_clock::now();
  REQUIRE(wait_until([&] { return std::chrono::steady_clock::now() - begin > 700ms; }));
  CHECK(stage.session.armed());
}

TEST_CASE("live osc: an order to arm that waited for a second is not obeyed", "[remote][live]") {
  Stage stage;
  test::OscClient client{(*stage.server)->port()};
  client.arm();
  const auto begin = std::chrono::steady_clock::now();
  REQUIRE(wait_until([&] {
    client.send({"/alive"});
    return std::chrono::steady_clock::now() - begin > 1100ms;
  }));
  stage.tick();
  CHECK_FALSE(stage.session.armed());
  CHECK(client.wait_for("/error"));
}

TEST_CASE("live osc: controls, ramps, triggers and bundles are journal entries at their frames",
          "[remote][live]") {
  Stage stage;
  test::OscClient client{(*stage.server)->port()};
  const auto value = [&](const char* name) { return stage.session.controls().find(name)->control.value; };
  const auto has = [&](const char* name, double wanted) {
    return stage.tick_until([&] { return value(name) == Approx(wanted); });
  };
  client.send({"/control/time", {50.0}});
  CHECK(has("time", 0.05));
  client.send({"/control/gain", {std::string{"-20 dB"}}});
  CHECK(has("gain", 0.1));
  client.send({"/control/gain", {-40.0, 0.2}});
  CHECK(has("gain", 0.01));
  client.send({"/trigger/start"});
  const double at_s = test::system_now_s() + 0.3;
  for (const int step : {0, 1, 2})
    client.send({{"/control/level", {0.01 + 0.01 * step}}, {"/control/time", {30.0 + step}}},
                at_s + 0.1 * step);
  CHECK(has("level", 0.03));
  CHECK(stage.session.controls().position(0) == Approx(0.25).margin(1e-6));
  const auto frame = stage.performer->instrument().frame();
  REQUIRE(stage.tick_until([&] { return stage.performer->instrument().frame() > frame + 4800; }));
  CHECK(stage.session.stop());
  const auto take = read_take(stage.wav);
  REQUIRE(take);
  const auto levels = changes(*take, "level"), times = changes(*take, "time"),
             starts = changes(*take, "start");
  REQUIRE(levels.size() == 3);
  REQUIRE(times.size() == 4);
  if (stage.remote.late() == 0)
    for (std::size_t step = 0; step < 3; ++step) {
      CHECK(levels[step].frame == times[step + 1].frame);
      // The clock model may have moved on by a few frames in 100 ms.
      CHECK(static_cast<double>(levels[step].frame - levels[0].frame) ==
            Approx(4800.0 * static_cast<double>(step)).margin(48));
    }
  REQUIRE(starts.size() == 2);
  CHECK(starts[1].frame == starts[0].frame + 1);
  const auto gains = changes(*take, "gain");
  REQUIRE(gains.size() == 21);  // one, then every 10 ms for 200 ms
  CHECK(gains.back().value == Approx(0.01));
  CHECK(gains[11].value == Approx(0.1 * std::pow(10, -1.0 * 11 / 20)));  // straight in decibels
}

TEST_CASE("play: a take with OSC control replays bit for bit", "[remote][live]") {
  const test::Desk desk;
  const auto wav = desk.file("take.wav");
  Program play{desk, {"--record", wav.string()}};
  test::OscClient client{play.port};
  client.send({"/control/level", {0.05}});
  client.send({"/control/gain", {-30.0, 0.3}});
  client.send({"/trigger/start"});
  client.send({{"/control/level", {0.11}}, {"/control/time", {5.0}}}, test::system_now_s() + 0.2);
  client.send({"/control/gain", {1000.0}});
  CHECK(client.wait_for("/error"));
  client.send({"/subscribe", {std::string{"/control/level"}, 50.0}});
  REQUIRE(wait_until([&] {
    const auto level = client.wait_for("/control/level");
    return level && std::get<double>(level->values[0]) == Approx(0.11);
  }));
  client.arm();
  const auto armed = client.wait_for("/armed");
  REQUIRE(armed);
  const auto begin = std::chrono::steady_clock::now();
  REQUIRE(wait_until([&] {
    client.send({"/alive"});
    return std::chrono::steady_clock::now() - begin > 1500ms;
  }));
  CHECK(client.wait_for("/armed"));  // 0: it is silent
  CHECK(play.stop() == 5);
  CHECK(play.log().find("drives armed by a remote client") != std::string::npos);
  const auto take = read_take(wav);
  REQUIRE(take);
  CHECK(changes(*take, "level").size() == 2);
  CHECK(changes(*take, "gain").size() >= 2);
  const auto samples = read_wav(wav);
  REQUIRE(samples);
  CHECK(*std::ranges::max_element(samples->channels[0]) > 0.05);
  const auto replayed = desk.run("render --replay take.wav");
  INFO(replayed.out << replayed.err);
  CHECK(replayed.exit == 0);
  CHECK(replayed.out.find("bit for bit") != std::string::npos);
}

TEST_CASE("play: the program lives through a flood of packets, and stops as before", "[remote][live]") {
  const test::Desk desk;
  Program play{desk};
  test::OscClient client{play.port};
  for (int n = 0; n < 20'000; ++n) {
    client.send({"/control/level", {0.0001 * (n % 1000)}});
    client.send_bytes("/control/" + std::string(static_cast<std::size_t>(n % 100), 'x'));
    client.send({"/trigger/start"});
  }
  client.send({"/subscribe", {std::string{"/state"}, 50.0}});
  REQUIRE(wait_until([&] {
    client.send({"/mute"});
    client.send({"/subscribe", {std::string{"/state"}, 50.0}});
    const auto muted = client.wait_for("/state/muted", 1s);
    return muted && muted->values == std::vector<OscValue>{1.0};
  }));
  CHECK(play.stop() == 5);
  CHECK(play.log().find("non-finite") == std::string::npos);
}

TEST_CASE("play: wrong OSC options are wrong usage", "[remote][live]") {
  const test::Desk desk;
  (void)desk.folder.write("tone.toml", kTone);
  test::check_exit(desk.run("play tone.toml --backend loop --osc nine"), 2, "--osc nine port");
  test::check_exit(desk.run("play tone.toml --osc 9000"), 2, "--osc card");
  test::check_exit(desk.run("play tone.toml --backend loop --osc-arm"), 2, "--osc-arm");
  test::check_exit(desk.run("play tone.toml --backend loop --osc 1.2.3.4:9000"), 2, "--osc 1.2.3.4:9000");
}
