#include <array>
#include <atomic>
#include <catch2/catch.hpp>
#include <thread>

#include "engine/core/guarded.h"
#include "tests/support/graph_runner.h"

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
  REQUIRE(guarded.prepare({48_kHz, 1, 1, kFrames}));
  AudioThread audio{guarded};
  int applied = 0;
  std::int64_t counted = 0, frame = 0;
  bool rising = true;
  for (int posted = 0; applied < kEntries;) {
    const auto kind = posted % 2 == 0 ? JournalEntry::Kind::Mute : JournalEntry::Kind::Arm;
    if (posted < kEntries && guarded.post({JournalEntry::kNow, kind, 0, posted % 4 < 2 ? 1.0 : 0.0}))
      ++posted;
    JournalEntry entry;
    while (guarded.take_applied(entry)) ++applied;
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

TEST_CASE("Engine: its faults and its frame are read from another thread while controls move", "[runtime]") {
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
