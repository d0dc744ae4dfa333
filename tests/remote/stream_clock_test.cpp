#include "remote/stream_clock.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <random>

using namespace tactus;

namespace {

constexpr double kStart_s = 1.8e9;

/// A stream at `rate` frames a second whose counter advances by `block`; read when a block ends, up to
/// `jitter_s` late.
struct Stream {
  double rate;
  int block;
  double jitter_s;
  std::mt19937 random{1};
  std::int64_t frame = 0;

  double true_frame(double time_s) const { return rate * (time_s - kStart_s); }
  void run(StreamClock& clock, double seconds) {
    std::uniform_real_distribution<double> late{0.0, jitter_s};
    for (const auto end = frame + std::llround(seconds * rate); frame < end;) {
      frame += block;
      clock.update(kStart_s + static_cast<double>(frame) / rate + late(random), frame);
    }
  }
};

}  // namespace

TEST_CASE("stream clock: within a few frames of a stream whose clock is 100 ppm fast", "[remote]") {
  const int block = GENERATE(32, 256, 1024);
  CAPTURE(block);
  StreamClock clock{48_kHz};
  CHECK_FALSE(clock.known());
  Stream stream{48'000 * 1.0001, block, 0.0};
  stream.run(clock, 30);
  CHECK(clock.known());
  const double soon_s = kStart_s + static_cast<double>(stream.frame) / stream.rate + 0.5;
  CHECK(clock.frame_at(soon_s) == Approx(stream.true_frame(soon_s)).margin(2.0));
  CHECK(clock.time_of(clock.frame_at(soon_s)) == Approx(soon_s).margin(1e-6));
}

TEST_CASE("stream clock: readings that are up to a block late spread what it predicts by less", "[remote]") {
  StreamClock clock{48_kHz};
  Stream stream{48'000, 64, 64.0 / 48'000};
  stream.run(clock, 10);
  double least = 1e9, most = -1e9;
  for (int n = 0; n < 100; ++n) {
    stream.run(clock, 0.1);
    const double soon_s = kStart_s + static_cast<double>(stream.frame) / stream.rate + 0.1;
    const double error = clock.frame_at(soon_s) - stream.true_frame(soon_s);
    least = std::min(least, error);
    most = std::max(most, error);
  }
  // The mean of being late is 32 frames. A reading counts for the time since the one before, which is longer
  // where it is late: 32 + 64 / 12 frames. One reading spreads by 64.
  CHECK(most < -37.3 + 4);
  CHECK(least > -37.3 - 4);
}

TEST_CASE("stream clock: a clock that is set, and a stream that stood still, start it again", "[remote]") {
  StreamClock clock{48_kHz};
  Stream stream{48'000, 64, 0.0};
  stream.run(clock, 5);
  const double now_s = kStart_s + static_cast<double>(stream.frame) / stream.rate;
  clock.update(now_s + 3600.0, stream.frame + 64);
  CHECK_FALSE(clock.known());
  CHECK(clock.frame_at(now_s + 3600.0) == Approx(static_cast<double>(stream.frame + 64)));
  clock.restart();
  clock.update(now_s, 64);
  CHECK(clock.frame_at(now_s + 1.0) == Approx(64.0 + 48'000));
}
