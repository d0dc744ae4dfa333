#include <array>
#include <atomic>
#include <catch2/catch.hpp>
#include <thread>

#include "engine/guard/guarded.h"
#include "tests/support/graphs/graph_runner.h"

using namespace tactus;

// What a control thread may do while the audio thread runs, all at once. The numbers show that nothing is
// lost; that nothing is torn shows under the thread sanitizer.

namespace {

/// A sample that is not finite, and then 1, in each block.
struct Faulty final : BlockProcessor {
  Status prepare(const StreamFormat&) override { return {}; }
  void process(const BlockIo& io) noexcept override {
    for (int n = 0; n < io.frames; ++n)
      io.out[0][n] = n == 0 ? std::numeric_limits<double>::quiet_NaN() : 0.1;
  }
};

/// Counts the entries that are applied.
struct CountingTap final : BlockTap {
  void applied(const JournalEntry&) noexcept override { ++entries; }
  void observe(const BlockIo&, std::int64_t) noexcept override {}
  std::atomic<int> entries{0};
};

constexpr int kFrames = 16;

/// Runs blocks on a thread of its own until `finish`; one of them begins after that.
class AudioThread {
 public:
  explicit AudioThread(BlockProcessor& processor)
      : thread_([this, &processor] {
          std::array<double, kFrames> in{}, out{};
          in[3] = std::numeric_limits<double>::infinity();
          const double* ins[] = {in.data()};
          double* outs[] = {out.data()};
          for (bool last = false; !last; ++blocks_) {
            last = finished_;
            processor.process({ins, outs, kFrames});
          }
        }) {}
  std::int64_t finish() {
    finished_ = true;
    thread_.join();
    return blocks_;
  }

 private:
  std::atomic<bool> finished_{false};
  std::int64_t blocks_ = 0;
  std::thread thread_;
};

}  // namespace

TEST_CASE("Guarded: arms, mutes and counts from another thread, every entry is applied", "[core]") {
  constexpr int kEntries = 2000;
  Faulty faulty;
  Guarded guarded{faulty, {}};
  CountingTap journal;
  guarded.set_tap(&journal);
  REQUIRE(guarded.prepare({48_kHz, 1, 1, kFrames}));
  AudioThread audio{guarded};
  int applied = 0;
  std::int64_t counted = 0, frame = 0;
  bool rising = true;
  for (int posted = 0; applied < kEntries;) {
    const auto kind = posted % 2 == 0 ? JournalEntry::Kind::Mute : JournalEntry::Kind::Arm;
    if (posted < kEntries && guarded.post({JournalEntry::kNow, kind, 0, posted % 4 < 2 ? 1.0 : 0.0}))
      ++posted;
    applied = journal.entries;
    const auto now = guarded.counts(0)[GuardStage::NonFinite].frames;
    rising = rising && now >= counted && guarded.frame() >= frame;
    counted = now;
    frame = guarded.frame();
  }
  const auto blocks = audio.finish();
  CHECK(applied == kEntries);
  CHECK(rising);
  CHECK(guarded.counts(0)[GuardStage::NonFinite].frames == blocks);
  CHECK(guarded.frame() == kFrames * blocks);
}

TEST_CASE("Player: its faults and its frame are read from another thread while controls move", "[runtime]") {
  const auto engine = test::engine_of(R"(format = 1
name = "test"
[inputs]
x = {}
[controls]
loud = { value = 1, range = [0, 1], smooth = "0 ms" }
[nodes]
too_loud = "1e300 * loud * 1e300"
[outputs]
y = { from = "too_loud + x" }
)");
  REQUIRE(engine->prepare({48_kHz, 1, 1, kFrames}));
  AudioThread audio{*engine};
  std::int64_t faults = 0, bad = 0, frame = 0;
  bool rising = true;
  for (int posted = 0; posted < 2000;) {
    if (engine->post({JournalEntry::kNow, JournalEntry::Kind::ControlChange, 0, posted % 2 * 1.0})) ++posted;
    const auto seen = engine->faults();
    const auto now = seen.empty() ? 0 : seen.front().count;
    rising = rising && now >= faults && engine->bad_input_samples() >= bad && engine->frame() >= frame;
    faults = now;
    bad = engine->bad_input_samples();
    frame = engine->frame();
  }
  const auto blocks = audio.finish();
  CHECK(rising);
  CHECK(!engine->faults().empty());
  CHECK(engine->frame() == kFrames * blocks);
  CHECK(engine->bad_input_samples() == blocks);
}

namespace {

/// The version says `gain` at its output: a number beside 16 combs and a string in their loops, an onset and
/// a network. Every second one has a node more, every third one a mass of its own.
std::unique_ptr<Plan> version(int number) {
  const auto gain = std::to_string(number);
  std::string text = R"(format = 1
name = "test"
[inputs]
x = {}
[controls]
loud  = { value = 0, range = [0, 1] }
pitch = { value = "300 Hz", range = ["100 Hz", "1 kHz"] }
[networks.drum]
frame = { type = "ground" }
cone  = { type = "mass", mass = "35 g" }
hold  = { type = "spring", between = ["frame", "cone"], stiffness = "1000 N/m", damping = "1.2 kg/s" }
push  = { type = "force", on = "cone", force = "1 N * x" }
[nodes]
combs = { type = "delay", voices = 16, in = "x + 0.5 * loss", time = { from = "1 ms", to = "9 ms" } }
loss  = { type = "low_pass", in = "combs", cutoff = "pitch * 4", q = 0.7 }
tuned = { type = "delay", in = "x + 0.9 * damped", time = "1 / pitch", compensate = ["damped"] }
damped = { type = "one_pole", in = "tuned", cutoff = "4 kHz" }
hit   = { type = "onset", in = "damped", threshold = "-34 dB" }
all   = { type = "mix", in = "loss" }
more  = ADDED
[outputs]
y = { from = "loud * (more + tuned + hit + drum.cone.position / 1 m) + " GAIN " }
)";
  const auto put = [&text](const std::string& from, const std::string& to) {
    text.replace(text.find(from), from.size(), to);
  };
  put("ADDED", number % 2 == 0 ? "\"all\"" : R"({ type = "one_pole", in = "all", cutoff = "1 kHz" })");
  if (number % 3 == 0) put("35 g", "30 g");
  put("\" GAIN \"", gain + "\"");
  return *compile(parse_graph_leniently(text, "test.toml"), standard_nodes(), {});
}

}  // namespace

TEST_CASE("Player: replaced from another thread, behind its guard, while controls move and counters are read",
          "[runtime][replace]") {
  constexpr int kVersions = 200;
  Player engine{version(0)};
  Guarded guarded{engine, {{DriveGuard::Kind::Audio, {}}}};
  REQUIRE(guarded.prepare({48_kHz, 1, 1, kFrames}));
  AudioThread audio{guarded};
  std::int64_t frame = 0;
  bool rising = true, accepted = true;
  for (int given = 0; given < kVersions || engine.replacing();) {
    const auto at = given % 2 == 0 ? JournalEntry::kNow : engine.frame() + 5;
    if (given < kVersions && !engine.replacing())
      accepted = engine.replace(version(++given), at).has_value() && accepted;
    for (const char* control : {"loud", "pitch"})
      (void)engine.post({JournalEntry::kNow, JournalEntry::Kind::ControlChange, engine.control_index(control),
                         given % 2 == 0 ? 1.0 : 500.0});
    rising = rising && engine.frame() >= frame && engine.faults().empty();
    frame = engine.frame();
  }
  const auto blocks = audio.finish();
  CHECK(accepted);
  CHECK(rising);
  CHECK(engine.frame() == kFrames * blocks);
  CHECK(engine.bad_input_samples() == blocks);
  // The last version plays: with the control at 0 its number alone is left.
  const std::array<double, kFrames> in{};
  std::array<double, kFrames> out{};
  const double* ins[] = {in.data()};
  double* outs[] = {out.data()};
  for (int block = 0; block < 200; ++block) {
    engine.process({ins, outs, kFrames});
    (void)engine.post(
        {JournalEntry::kNow, JournalEntry::Kind::ControlChange, engine.control_index("loud"), 0});
  }
  CHECK(out[kFrames - 1] == kVersions);
}
