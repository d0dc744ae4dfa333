#include <catch2/catch.hpp>
#include <random>
#include <vector>

#include "backends/card_callback.h"

using namespace tactus;

namespace {

/// A stream of blocks, each as late as `late_seconds` says, of which some frames never come.
struct TestStream {
  double rate = 48000.0;
  int block = 256;
  double clock = 1.0;  ///< the card's over ours

  /// Plays; what was found missing, block by block.
  template <class Late>
  std::vector<std::int64_t> play(FrameWatch& watch, double seconds, Late late) {
    std::vector<std::int64_t> found;
    for (const double end = now + seconds; now < end; now += block / rate * clock) {
      found.push_back(watch.block(frames, block, now + late()));
      frames += block;
    }
    return found;
  }
  void lose(int count) { now += count / rate; }

  double now = 100.0;
  std::int64_t frames = 0;
};

std::int64_t sum(const std::vector<std::int64_t>& found) {
  std::int64_t all = 0;
  for (const auto missing : found) all += missing;
  return all;
}

const auto kOnTime = [] { return 0.0; };

}  // namespace

TEST_CASE("frame watch: finds how many frames are missing, within a second", "[backends]") {
  const int lost = GENERATE(300, 1000, 4800, 96000);
  const int block = GENERATE(16, 64, 256);
  FrameWatch watch{48000.0};
  TestStream stream{.block = block};
  CHECK(sum(stream.play(watch, 2.0, kOnTime)) == 0);
  stream.lose(lost);
  CHECK(std::llabs(sum(stream.play(watch, 1.1, kOnTime)) - lost) <= 1);
  CHECK(sum(stream.play(watch, 5.0, kOnTime)) == 0);
}

TEST_CASE("frame watch: blocks that come late, but come, are not missing", "[backends]") {
  FrameWatch watch{48000.0};
  TestStream stream;
  std::mt19937 random{1};
  std::exponential_distribution<double> late{1 / 0.002};  // 2 ms on average
  CHECK(sum(stream.play(watch, 60.0, [&] { return late(random); })) == 0);
}

TEST_CASE("frame watch: a stall that is caught up with is no loss", "[backends]") {
  FrameWatch watch{48000.0};
  TestStream stream;
  stream.play(watch, 2.0, kOnTime);
  double late = 0.3;  // the blocks of 300 ms come in one go
  CHECK(sum(stream.play(watch, 0.3, [&] { return late = std::max(0.0, late - 256 / 48000.0); })) == 0);
  CHECK(sum(stream.play(watch, 5.0, kOnTime)) == 0);
}

TEST_CASE("frame watch: clocks that are 0.1 % apart lose nothing", "[backends]") {
  FrameWatch watch{48000.0};
  TestStream stream{.block = 64, .clock = GENERATE(0.999, 1.001)};
  CHECK(sum(stream.play(watch, 60.0, kOnTime)) == 0);
}

TEST_CASE("frame watch: blocks longer than its half second are no loss", "[backends]") {
  FrameWatch watch{8000.0};
  TestStream stream{.rate = 8000.0, .block = 8192};
  CHECK(sum(stream.play(watch, 60.0, kOnTime)) == 0);
  stream.lose(3 * 8192);
  CHECK(sum(stream.play(watch, 10.0, kOnTime)) == 3 * 8192);
}

TEST_CASE("frame watch: frames that run ahead of time are noticed within 1.1 s of them", "[backends]") {
  FrameWatch watch{48000.0};
  TestStream stream;
  std::int64_t unnoticed = 0;
  const auto play = [&](double seconds, double pace) {
    for (const double end = stream.now + seconds; stream.now < end;
         stream.now += stream.block / stream.rate / pace) {
      CHECK(watch.block(stream.frames, stream.block, stream.now) == 0);
      stream.frames += stream.block;
      if (!watch.ahead()) unnoticed += stream.block;
    }
  };
  play(2.0, 1.0);
  CHECK_FALSE(watch.ahead());
  unnoticed = 0;
  play(5.0, 20.0);  // 100 s of frames
  CHECK(watch.ahead());
  CHECK(unnoticed <= 52800);  // half a second, and once more where the watch's own half second ends just then
  play(2.0, 1.0);
  CHECK_FALSE(watch.ahead());
}
