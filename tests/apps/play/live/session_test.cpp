#include "apps/play/live/session.h"

#include <algorithm>
#include <atomic>
#include <catch2/catch.hpp>
#include <csignal>

#include "apps/cli/stop_loop.h"
#include "backends/loop/loop.h"
#include "backends/take/take.h"
#include "backends/wav_file.h"
#include "engine/core/index.h"
#include "tests/support/keyboard.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/wait_until.h"

using namespace tactus;
using namespace tactus::app;
using test::wait_until;

namespace {

std::string constant(const std::string& level) {
  return "format = 1\nname = \"constant\"\n[outputs]\ntone = { from = \"" + level + "\" }\n";
}

/// An instrument that is compiled again when the test allows it.
class SlowToCompile final : public Performer {
 public:
  explicit SlowToCompile(std::unique_ptr<Performer> inner) : Performer(*inner), inner_(std::move(inner)) {}
  BlockProcessor& processor() override { return inner_->processor(); }
  Player& instrument() override { return inner_->instrument(); }
  Edit read_edit() override {
    reading = true;
    (void)wait_until([&] { return allowed.load(); });
    reading = false;
    return inner_->read_edit();
  }

  std::atomic<bool> reading{false}, allowed{false};

 private:
  std::unique_ptr<Performer> inner_;
};

/// A loop of 5 ms that grows by half each time.
const std::string kFeedback = R"(format = 1
name = "feedback"
[nodes]
kick = { type = "sine", level = 0.01, frequency = "100 Hz" }
x = "kick + 1.5 * echo"
echo = { type = "delay", in = "x", time = "5 ms" }
[outputs]
tone = { from = "x" }
)";

struct Stage {
  explicit Stage(const std::string& graph = constant("0.1"))
      : performer{make_instrument({resolve_target(folder.write("tone.toml", graph).string())})} {
    request.out_channels = 1;
  }
  bool says(Session& session, const std::string& words) {
    return wait_until([&] {
      session.tick();
      for (const auto& message : session.take_messages())
        if (message.find(words) != std::string::npos) return true;
      return false;
    });
  }

  static double highest_of_ten_blocks(Session& session) {
    const auto before = session.view().health.blocks;
    double highest = 0.0;
    REQUIRE(wait_until([&] {
      const auto& view = session.view();
      highest = std::max(highest, view.outputs[0].peak);
      return view.health.blocks >= before + 10;
    }));
    return highest;
  }

  test::TemporaryFolder folder;
  SlowToCompile performer;
  LoopBackend backend;
  StreamRequest request;
};

}  // namespace

TEST_CASE("session: it ticks, fades and stops while a file is compiled, however long that takes", "[live]") {
  Stage stage;
  Session session{stage.performer, stage.backend, stage.request, true};
  REQUIRE(session.open({}));
  REQUIRE(session.start());
  stage.folder.write("tone.toml", constant("0.25"));
  REQUIRE(wait_until([&] { return session.tick(), stage.performer.reading.load(); }));
  const auto before = session.view().health.blocks;
  REQUIRE(wait_until([&] { return session.tick(), session.view().health.blocks > before + 10; }));
  CHECK(session.stop());
  CHECK(session.view().state == StreamState::Stopped);
  CHECK(stage.performer.reading);
  stage.performer.allowed = true;
}

TEST_CASE("session: a key, a signal or a further stop input ends it while a file is compiled", "[live]") {
  const std::string by = GENERATE(as<std::string>{}, "key", "signal", "input");
  CAPTURE(by);
  Stage stage;
  const test::Keyboard keyboard;
  DeadMansSwitch dead_man;
  Session session{stage.performer, stage.backend, stage.request, true, &dead_man};
  std::atomic<bool> pressed{false};
  StopLoop loop{dead_man,
                {.act = {}, .inputs = {[&] { return pressed.load(); }}, .fade = session.closing_time()}};
  const auto wav = stage.folder.path() / "take.wav";
  REQUIRE(session.open(wav));
  REQUIRE(session.start());
  REQUIRE(wait_until([&] { return session.view().outputs[0].peak == Approx(0.1); }));
  stage.folder.write("tone.toml", constant("0.25"));
  REQUIRE(wait_until([&] { return session.tick(), stage.performer.reading.load(); }));
  if (by == "key") keyboard.press('q');
  if (by == "signal") std::raise(SIGTERM);
  pressed = by == "input";
  REQUIRE(wait_until([&] { return loop.ending() != StopLoop::Ending::None; }));
  // The stop input alone causes the fade: session.stop() has not been called yet.
  REQUIRE(wait_until([&] { return Stage::highest_of_ten_blocks(session) == 0.0; }));
  CHECK(session.stop());
  CHECK(read_take(wav)->finished);
  CHECK(read_wav(wav)->channels[0].back() == 0.0);
  CHECK(stage.performer.reading);
  stage.performer.allowed = true;
}

TEST_CASE("session: a recording that begins while it plays begins at rest, and ends without a gap",
          "[live]") {
  Stage stage{R"(format = 1
name = "ramp"
[nodes]
ramp = { type = "delay", in = "ramp + 0.000001", time = "1 ms" }
[outputs]
tone = { from = "0.5 * ramp" }
)"};
  Session session{stage.performer, stage.backend, stage.request, true};
  REQUIRE(session.open({}));
  REQUIRE(session.start());
  CHECK_FALSE(session.recording());
  const auto wav = stage.folder.path() / "take.wav";
  stage.folder.write("take-2.wav", "what a full disk left");
  for (int take = 1; take <= 2; ++take) {
    REQUIRE(session.start_recording(wav));
    CHECK(session.recording());
    CHECK(session.armed());
    REQUIRE(wait_until([&] {
      session.tick();
      return session.view().recorded_s > 0.1;
    }));
    session.stop_recording();
    CHECK_FALSE(session.recording());
    const auto blocks = session.view().health.blocks;
    REQUIRE(stage.says(session, "recorded "));
    CHECK_FALSE(session.view().recorded_s);
    CHECK(wait_until([&] { return session.view().health.blocks > blocks + 10; }));
    REQUIRE(session.takes().size() == index(take));
    const auto read = read_take(session.takes().back());
    REQUIRE(read);
    CHECK(read->finished);
    CHECK(read->gaps.empty());
    CHECK(read->header.armed);
    CHECK(read->complete == read_wav(session.takes().back())->frames());
  }
  CHECK(session.takes() == std::vector{wav, stage.folder.path() / "take-3.wav"});
  CHECK(session.view().health.xruns == 0);
}

TEST_CASE("session: a recording that cannot be written is reported, and the instrument plays", "[live]") {
  Stage stage;
  Session session{stage.performer, stage.backend, stage.request, true};
  REQUIRE(session.open({}));
  REQUIRE(session.start());
  REQUIRE(session.start_recording(stage.folder.path() / "missing" / "take.wav"));
  CHECK_FALSE(session.recording());
  CHECK(stage.says(session, "nothing is recorded: "));
  CHECK(wait_until([&] { return Stage::highest_of_ten_blocks(session) > 0.05; }));
}

TEST_CASE("session: a compiled edit takes over, and a broken one changes nothing", "[live]") {
  Stage stage;
  stage.performer.allowed = true;
  Session session{stage.performer, stage.backend, stage.request, true};
  REQUIRE(session.open({}));
  REQUIRE(session.start());
  stage.folder.write("tone.toml", constant("0.25 + nothing"));
  CHECK(stage.says(session, "the previous version keeps playing"));
  stage.folder.write("tone.toml", constant("0.25"));
  CHECK(stage.says(session, "edit applied"));
  CHECK(wait_until([&] { return session.view().outputs[0].peak == Approx(0.25); }));
}

TEST_CASE("session: one that an exception ends comes to zero first", "[live]") {
  Stage stage;
  test::TemporaryFolder folder;
  const auto wav = folder.path() / "take.wav";
  try {
    Session session{stage.performer, stage.backend, stage.request, true};
    REQUIRE(session.open(wav));
    REQUIRE(session.start());
    REQUIRE(wait_until([&] { return session.view().outputs[0].peak == Approx(0.1); }));
    throw std::bad_alloc{};
  } catch (const std::bad_alloc&) {
  }
  const auto samples = read_wav(wav);
  REQUIRE(samples);
  CHECK(samples->channels[0].back() == 0.0);
  stage.performer.allowed = true;
}

TEST_CASE("session: sound that feedback faded can be armed again", "[live]") {
  Stage stage{kFeedback};
  stage.performer.guards[0].kind = DriveGuard::Kind::Audio;
  Session session{stage.performer, stage.backend, stage.request, false};
  CHECK_FALSE(session.has_drives());
  REQUIRE(session.open({}));
  REQUIRE(session.start());
  CHECK(stage.says(session, "tone: feedback at"));
  CHECK(session.has_drives());
  session.switches().order_arm();
  REQUIRE(session.arm(true));
  CHECK(stage.says(session, "tone: feedback at"));  // it played again
}

TEST_CASE("recording monitor: each message once, and none about a disk that is full already", "[live]") {
  RecordingMonitor monitor;
  CHECK(monitor.update({.recorded = {}, .dropped_frames = 0, .error = {}, .messages = {}}).empty());
  CHECK(monitor.update({.recorded = {}, .dropped_frames = 64, .error = {}, .messages = {}}).size() == 1);
  CHECK(monitor.update({.recorded = {}, .dropped_frames = 64, .error = {}, .messages = {}}).empty());
  const auto stopped =
      monitor.update({.recorded = {}, .dropped_frames = 64, .error = "full", .messages = {}});
  REQUIRE(stopped.size() == 1);
  CHECK(stopped[0].starts_with("recording stopped: full"));
  for (int dropped = 100; dropped < 200; ++dropped)
    CHECK(
        monitor.update({.recorded = {}, .dropped_frames = dropped, .error = "full", .messages = {}}).empty());
}
