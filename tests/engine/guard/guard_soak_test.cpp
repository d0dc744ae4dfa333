#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <limits>
#include <random>
#include <vector>

#include "engine/guard/guarded.h"

using namespace tactus;

// Blocks that nobody would send on purpose, through guards of random limits.

namespace {

constexpr int kLongest = 4096;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

class Dice {
 public:
  explicit Dice(std::uint64_t seed) : random_(seed) {}
  double uniform(double low, double high) {
    return low + (high - low) * static_cast<double>(random_() >> 11) * 0x1p-53;
  }
  double logarithmic(double low, double high) { return low * std::pow(high / low, uniform(0, 1)); }
  int below(int n) { return static_cast<int>(random_() % static_cast<std::uint64_t>(n)); }
  bool one_in(int n) { return below(n) == 0; }

 private:
  std::mt19937_64 random_;
};

DriveLimits any_limits(Dice& dice) {
  DriveLimits limits;
  limits.ceiling = dice.uniform(0.01, 1.0);
  if (!dice.one_in(4)) limits.slew_per_second = dice.logarithmic(1.0, 1e6);
  limits.soft_start = Seconds{dice.one_in(2) ? 0.0 : dice.uniform(0, 0.1)};
  limits.fade_out = Seconds{dice.one_in(2) ? 0.0 : dice.uniform(0, 0.05)};
  if (dice.one_in(2))
    limits.heat = HeatLimits{.watts_at_full_scale = dice.logarithmic(0.1, 1000),
                             .watts_for_ever = dice.logarithmic(0.1, 100),
                             .coil_time = Seconds{dice.logarithmic(0.01, 10)},
                             .body_time = Seconds{dice.logarithmic(0.1, 1000)},
                             .coil_share = dice.uniform(0.05, 0.95)};
  if (dice.one_in(2))
    limits.excursion = ExcursionLimits{.metres = dice.logarithmic(1e-4, 1e-2),
                                       .metres_at_full_scale = dice.logarithmic(1e-5, 1e-1),
                                       .resonance = Hertz{dice.logarithmic(5, 1000)},
                                       .q = dice.logarithmic(0.1, 50)};
  if (dice.one_in(2)) limits.dc = {dice.uniform(0.01, 1.0), Seconds{dice.uniform(0, 1)}};
  return limits;
}

/// Limits that can be kept.
DriveLimits random_limits(Dice& dice, Hertz rate) {
  for (;;)
    if (const auto limits = any_limits(dice); check(limits, rate)) return limits;
}

/// What comes out of the processor inside: something bad, another thing each block.
class Chaos final : public BlockProcessor {
 public:
  explicit Chaos(std::uint64_t seed) : dice_(seed) {}
  Status prepare(const StreamFormat&) override { return {}; }
  void process(const BlockIo& io) noexcept override {
    const int kind = dice_.below(10);
    const double size = dice_.logarithmic(1e-3, 1e3);
    for (int n = 0; n < io.frames; ++n) io.out[0][n] = sample(kind, size, n);
  }

 private:
  double sample(int kind, double size, int n) {
    switch (kind) {
      case 0:
        return dice_.uniform(-1, 1) * size;
      case 1:
        return n % 2 == 0 ? size : -size;
      case 2:
        return size;
      case 3:
        return dice_.one_in(9) ? kInfinity : dice_.uniform(-1, 1);
      case 4:
        return dice_.one_in(9) ? std::numeric_limits<double>::quiet_NaN() : -kInfinity;
      case 5:
        return dice_.one_in(2) ? std::numeric_limits<double>::denorm_min() : -1e-310;
      case 6:
        return dice_.one_in(50) ? -std::numeric_limits<double>::max() : 0.01;
      case 7:
        return 0.0;
      case 8:
        return size * std::sin(0.001 * size * n);
      default:
        return 1e-3 * dice_.uniform(-1, 1);
    }
  }
  Dice dice_;
};

struct Broken {
  std::int64_t ceiling = 0, slew = 0, not_finite = 0, heat = 0;
  bool operator==(const Broken&) const = default;
};

/// Runs `blocks` blocks of 1 to `longest` frames and looks at every sample.
Broken soak(std::int64_t blocks, int longest, std::uint64_t seed) {
  Dice dice{seed};
  Broken broken;
  std::vector<double> out(kLongest);
  double* channels[] = {out.data()};
  for (std::int64_t left = blocks; left > 0;) {
    const Hertz rate{dice.logarithmic(8e3, 192e3)};
    const auto limits = random_limits(dice, rate);
    Chaos chaos{seed + static_cast<std::uint64_t>(left)};
    Guarded guarded{chaos, {{DriveGuard::Kind::Drive, limits}}, dice.one_in(2)};
    if (!guarded.prepare({rate, 0, 1, kLongest})) throw std::runtime_error("limits were refused");
    // A difference of two doubles near 1 is itself rounded, by 2^-53 at most.
    const double step = limits.slew_per_second / rate.value + 0x1p-53;
    double last = 0.0;
    for (int block = 0; block < 200 && left > 0; ++block, --left) {
      if (dice.one_in(3)) {
        const auto kind = dice.one_in(3) ? JournalEntry::Kind::Mute : JournalEntry::Kind::Arm;
        (void)guarded.post({guarded.frame() + dice.below(longest), kind, 0, dice.one_in(3) ? 0.0 : 1.0});
      }
      const int frames = 1 + dice.below(longest);
      guarded.process({nullptr, channels, frames});
      for (int n = 0; n < frames; ++n) {
        const double y = out[static_cast<std::size_t>(n)];
        broken.not_finite += std::isfinite(y) ? 0 : 1;
        broken.ceiling += std::abs(y) > limits.ceiling ? 1 : 0;
        broken.slew += std::abs(y - last) > step ? 1 : 0;
        last = y;
      }
      broken.heat += guarded.thermal_state(0).coil > 1.0 ? 1 : 0;
    }
  }
  return broken;
}

}  // namespace

TEST_CASE("guard: 20,000 adversarial random blocks, not one sample over ceiling or slew", "[core]") {
  const auto broken = soak(20'000, 300, 1);
  CHECK(broken.not_finite == 0);
  CHECK(broken.ceiling == 0);
  CHECK(broken.slew == 0);
  CHECK(broken.heat == 0);
}

TEST_CASE("guard: a million adversarial random blocks of up to 4096 frames", "[.soak]") {
  std::int64_t done = 0;
  for (std::uint64_t part = 0; part < 100; ++part, done += 10'000) {
    INFO("seed " << 1000 * part);
    const auto broken = soak(10'000, kLongest, 1000 * part);
    CHECK(broken.not_finite == 0);
    CHECK(broken.ceiling == 0);
    CHECK(broken.slew == 0);
    CHECK(broken.heat == 0);
    std::printf("%lld blocks\n", static_cast<long long>(done + 10'000));
    std::fflush(stdout);
  }
}

TEST_CASE("guard: however its frames are cut, the same bits, counts and howls", "[core]") {
  Dice dice{7};
  for (int turn = 0; turn < 60; ++turn) {
    auto limits = random_limits(dice, 48_kHz);
    if (turn % 3 != 0) limits.fade_out = Seconds{0.01};
    std::vector<double> input(30'000);
    Chaos chaos{static_cast<std::uint64_t>(turn)};
    for (int at = 0; at < 30'000; at += 500) {
      double* out = input.data() + at;
      chaos.process({nullptr, &out, 500});
    }
    const auto run = [&](int block) {
      DriveGuard guard{DriveGuard::Kind::Drive, limits, 48_kHz};
      guard.set_open(true, 0);
      auto samples = input;
      for (int at = 0; at < 30'000; at += block) {
        const int frames = std::min(block, 30'000 - at);
        guard.process(samples.data() + at, frames, at);
      }
      return std::pair{samples, guard.counts()};
    };
    const auto whole = run(30'000);
    for (const int block : {1, 5, 64, 100, 333}) {
      INFO("turn " << turn << ", blocks of " << block);
      const auto cut = run(block);
      CHECK(std::memcmp(cut.first.data(), whole.first.data(), 30'000 * sizeof(double)) == 0);
      CHECK(cut.second == whole.second);
    }
  }
}
