#include "engine/guard/dc_limiter.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "engine/guard/drive_guard.h"

using namespace tactus;

namespace {

constexpr Hertz kRate = 48_kHz;

/// A drive under a limit on direct current alone, second by second.
class Drive {
 public:
  explicit Drive(const DcLimits& limits) : guard_(DriveGuard::Kind::Drive, {.dc = limits}, kRate) {
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
