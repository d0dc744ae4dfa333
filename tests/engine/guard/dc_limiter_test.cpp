#include "engine/guard/dc_limiter.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <numeric>
#include <vector>

#include "engine/guard/drive_guard.h"

using namespace tactus;

namespace {

constexpr Hertz kRate = 48_kHz;

/// A drive under a limit on direct current alone, second by second.
class Drive {
 public:
  explicit Drive(const DcLimits& limits) : Drive(DriveLimits{.dc = limits}) {}
  explicit Drive(const DriveLimits& limits)
      : guard_(DriveGuard::Kind::Drive, limits, kRate, {.from_input = false, .internal_loop = false}) {
    guard_.set_open(true, 0);
  }
  /// The output of one more second of signal(time in seconds).
  template <class Signal>
  std::vector<double> second(Signal signal) {
    std::vector<double> samples(48'000);
    for (auto& sample : samples) sample = signal(static_cast<double>(frame_++) / kRate.value);
    guard_.process(samples.data(), 48'000, frame_ - 48'000);
    return samples;
  }
  std::int64_t held_back() const { return guard_.counts()[GuardStage::Dc].frames; }

 private:
  DriveGuard guard_;
  std::int64_t frame_ = 0;
};

double mean_of(const std::vector<double>& samples) {
  return std::accumulate(samples.begin(), samples.end(), 0.0) / static_cast<double>(samples.size());
}

/// `high` for the first `highs` of `period` frames, and below 0 for the others so that its mean is 0.
struct Train {
  double high;
  int highs, period;
  double operator()(double t) const {
    const auto frame = std::llround(t * kRate.value) % period;
    return frame < highs ? high : -high * highs / (period - highs);
  }
};

}  // namespace

TEST_CASE("direct: a held force passes for its time, and is then what may last for ever", "[core]") {
  Drive drive{{.level = 0.2, .time = Seconds{3.0}}};
  const auto held = [](double) { return 0.8; };
  for (int second = 0; second < 3; ++second) CHECK(drive.second(held) == std::vector<double>(48'000, 0.8));
  drive.second(held);
  drive.second(held);
  // 0.2 / 0.8 of it, after the mean has settled: e^-10 of it is left to come.
  CHECK(drive.second(held).back() == Approx(0.2).epsilon(1e-3));
}

TEST_CASE("direct: what stays within the level, and what swings around 0, is left alone", "[core]") {
  Drive drive{{.level = 0.2, .time = Seconds{1.0}}};
  for (int second = 0; second < 5; ++second) drive.second([](double) { return -0.199; });
  for (int second = 0; second < 5; ++second)
    drive.second([](double t) { return std::sin(2 * 3.141592653589793 * 5.0 * t); });
  // One-sided pulses count as their mean: 16 a second of 6 ms are 0.096.
  for (int second = 0; second < 5; ++second)
    drive.second([](double t) { return std::exp(-std::fmod(t, 1.0 / 16) / 0.006); });
  CHECK(drive.held_back() == 0);
}

TEST_CASE("direct: a drive that rested has its time again", "[core]") {
  Drive drive{{.level = 0.2, .time = Seconds{2.0}}};
  const auto held = [](double) { return 1.0; };
  const auto rest = [](double) { return 0.0; };
  for (int second = 0; second < 4; ++second) drive.second(held);
  CHECK(drive.held_back() > 0);
  for (int second = 0; second < 4; ++second) drive.second(rest);
  CHECK(drive.second(held) == std::vector<double>(48'000, 1.0));
}

TEST_CASE("direct: DC that the slew limit makes of a signal without any counts", "[core]") {
  // Up 3 frames, down 2: with steps of 1/8 it never comes lower than 2/8 below its top of 0.375 g, and its
  // mean is 0.375 g - (1 + 2 + 1) / 8 / 5, or 0.275 at g = 1 and the level 0.15 at g = 2/3.
  const Train train{.high = 0.375, .highs = 3, .period = 5};
  Drive without{DriveLimits{.slew_per_second = kRate.value / 8}};
  without.second(train);
  CHECK(mean_of(without.second(train)) == Approx(0.275).epsilon(1e-3));
  Drive drive{DriveLimits{.slew_per_second = kRate.value / 8, .dc = {.level = 0.15, .time = Seconds{2.0}}}};
  for (int second = 0; second < 2; ++second) drive.second(train);
  CHECK(drive.held_back() == 0);
  for (int second = 0; second < 10; ++second) drive.second(train);
  for (int second = 0; second < 5; ++second)
    CHECK(mean_of(drive.second(train)) == Approx(0.15).epsilon(1e-3));
}

TEST_CASE("direct: so does DC that the excursion limit makes", "[core]") {
  // Short high pulses are cut, long low ones are not.
  const Train train{.high = 0.9, .highs = 960, .period = 9600};
  DriveLimits limits{.excursion = ExcursionLimits{
                         .metres = 1e-3, .metres_at_full_scale = 5e-3, .resonance = 30_Hz, .q = 0.7}};
  Drive without{limits};
  without.second(train);
  REQUIRE(mean_of(without.second(train)) < -0.04);
  limits.dc = {.level = 0.02, .time = Seconds{1.0}};
  Drive drive{limits};
  for (int second = 0; second < 10; ++second) drive.second(train);
  for (int second = 0; second < 5; ++second) CHECK(std::abs(mean_of(drive.second(train))) < 0.02 * 1.01);
}

TEST_CASE("direct: limits that cut both sides alike leave the drive alone", "[core]") {
  Drive drive{DriveLimits{.slew_per_second = 500.0, .dc = {.level = 0.05, .time = Seconds{1.0}}}};
  for (int second = 0; second < 10; ++second)
    drive.second([](double t) { return std::sin(2 * 3.141592653589793 * 400.0 * t); });
  CHECK(drive.held_back() == 0);
}
