#include "engine/guard/drive_guard.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <limits>
#include <random>
#include <vector>

#include "tests/support/error_summary.h"

using namespace tactus;

namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

struct OpenGuard : DriveGuard {
  explicit OpenGuard(const DriveLimits& limits, Kind kind = Kind::Drive) : DriveGuard(kind, limits, 48_kHz) {
    set_open(true, 0);
  }
};

std::vector<double> noise(std::size_t frames, double peak) {
  std::mt19937 random{1};
  std::uniform_real_distribution<double> uniform{-peak, peak};
  std::vector<double> samples(frames);
  for (auto& sample : samples) sample = uniform(random);
  return samples;
}

bool same_bits(const std::vector<double>& a, const std::vector<double>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(double)) == 0;
}

/// The count of a stage, after a look that no other one had anything to do.
StageCount only(const DriveGuard& guard, GuardStage::Index stage) {
  auto rest = guard.counts();
  rest[stage] = {};
  CHECK(rest == GuardCounts{});
  return guard.counts()[stage];
}

void run(DriveGuard& guard, std::vector<double>& samples, std::int64_t first = 0) {
  guard.process(samples.data(), static_cast<int>(samples.size()), first);
}

}  // namespace

TEST_CASE("drive_guard: within its limits the output is the input, bit for bit and undelayed", "[core]") {
  // The largest step of this noise is 1.8 a frame: 86,400 full scales a second at 48 kHz.
  OpenGuard guard{{.ceiling = 0.9, .slew_per_second = 86'401.0}};
  const auto input = noise(1000, 0.9);
  auto output = input;
  output[7] = -0.0;
  auto expected = output;
  run(guard, output);
  CHECK(same_bits(output, expected));
  CHECK(guard.counts() == GuardCounts{});
}

TEST_CASE("drive_guard: a closed guard lets nothing through", "[core]") {
  DriveGuard guard{DriveGuard::Kind::Drive, {}, 48_kHz};
  auto samples = noise(100, 1.0);
  run(guard, samples);
  for (const double sample : samples) CHECK(sample == 0.0);
}

TEST_CASE("drive_guard: a NaN or infinity becomes silence and is counted", "[core]") {
  OpenGuard guard{DriveLimits{}};
  std::vector<double> samples = {0.5, kNan, kInfinity, -kInfinity, -0.5};
  run(guard, samples);
  CHECK(samples == std::vector<double>{0.5, 0.0, 0.0, 0.0, -0.5});
  CHECK(only(guard, GuardStage::NonFinite).frames == 3);
}

TEST_CASE("drive_guard: nothing passes the ceiling, and the ceiling itself is within it", "[core]") {
  OpenGuard guard{{.ceiling = 0.25}};
  std::vector<double> samples = {0.2, 0.25, 0.3, 1e300, -0.25, -7.0};
  run(guard, samples);
  CHECK(samples == std::vector<double>{0.2, 0.25, 0.25, 0.25, -0.25, -0.25});
  CHECK(only(guard, GuardStage::Ceiling).frames == 3);
}

TEST_CASE("drive_guard: a step becomes a line of the slew limit", "[core]") {
  // 6,000 full scales a second at 48 kHz are 1/8 a frame, exact in binary.
  OpenGuard guard{{.slew_per_second = 6000.0}};
  std::vector<double> samples(12, 1.0);
  run(guard, samples);
  for (std::size_t n = 0; n < samples.size(); ++n)
    CHECK(samples[n] == std::min(1.0, 0.125 * static_cast<double>(n + 1)));
  // Frames 0 to 6 were held back; frame 7 is where the line meets the step.
  CHECK(only(guard, GuardStage::Slew).frames == 7);
  CHECK(only(guard, GuardStage::Slew).most == 0.875);
}

TEST_CASE("drive_guard: audio is not slewed", "[core]") {
  OpenGuard guard{{.slew_per_second = 6000.0}, DriveGuard::Kind::Audio};
  std::vector<double> samples(4, 1.0);
  run(guard, samples);
  CHECK(samples == std::vector<double>(4, 1.0));
}

TEST_CASE("drive_guard: soft start and fade out are straight lines in absolute frames", "[core]") {
  // 1 ms at 48 kHz: 48 frames up; 0.5 ms: 24 frames down.
  DriveGuard guard{DriveGuard::Kind::Drive, {.soft_start = 1_ms, .fade_out = 0.5_ms}, 48_kHz};
  guard.set_open(true, 10);
  std::vector<double> samples(100, 1.0);
  run(guard, samples);
  CHECK(samples[9] == 0.0);
  CHECK(samples[10] == 0.0);
  CHECK(samples[11] == Approx(1.0 / 48).epsilon(1e-15));
  CHECK(samples[34] == 0.5);
  CHECK(samples[57] == Approx(47.0 / 48).epsilon(1e-15));
  CHECK(samples[58] == 1.0);

  guard.set_open(false, 100);
  std::vector<double> after(30, 1.0);
  run(guard, after, 100);
  CHECK(after[0] == 1.0);
  CHECK(after[12] == 0.5);
  CHECK(after[24] == 0.0);
}

TEST_CASE("drive_guard: a reversed ramp starts where the first one was", "[core]") {
  Ramp ramp;
  ramp.move_to(1.0, 0, 100);
  ramp.move_to(0.0, 30, 10);
  CHECK(ramp.at(30) == Approx(0.3).epsilon(1e-15));
  CHECK(ramp.at(35) == Approx(0.15).epsilon(1e-15));
  CHECK(ramp.at(40) == 0.0);
}

TEST_CASE("drive_guard: how frames are cut into blocks changes no bit", "[core]") {
  const DriveLimits limits{.ceiling = 0.7, .slew_per_second = 20'000.0, .soft_start = 2.7_ms};
  auto input = noise(1000, 1.0);
  input[500] = kNan;
  auto whole = input;
  OpenGuard guard{limits};
  run(guard, whole);

  const int block = GENERATE(1, 3, 64, 333);
  auto cut = input;
  OpenGuard cut_guard{limits};
  for (int at = 0; at < 1000; at += block) cut_guard.process(cut.data() + at, std::min(block, 1000 - at), at);
  CHECK(same_bits(cut, whole));
  CHECK(cut_guard.counts() == guard.counts());
  CHECK(guard.counts()[GuardStage::Slew].frames > 0);
  CHECK(guard.counts()[GuardStage::Ceiling].frames > 0);
}

TEST_CASE("drive_guard: limits that make no sense are refused in words", "[core]") {
  CHECK(check({}).has_value());
  CHECK(test::summary(check({.ceiling = 1.5})) == "OutOfRange 0 1");
  CHECK_FALSE(check({.ceiling = 0.0}));
  CHECK_FALSE(check({.ceiling = kNan}));
  CHECK_FALSE(check({.slew_per_second = 0.0}));
  CHECK_FALSE(check({.slew_per_second = kNan}));
  CHECK_FALSE(check({.soft_start = Seconds{-1.0}}));
  CHECK_FALSE(check({.fade_out = Seconds{kNan}}));
  CHECK_FALSE(check({.heat = HeatLimits{}}));
  CHECK_FALSE(check({.heat = HeatLimits{.watts_at_full_scale = 1, .watts_for_ever = 1, .coil_time = 1_ms}}));
  CHECK_FALSE(check({.heat = HeatLimits{.watts_at_full_scale = 1, .watts_for_ever = 1, .coil_share = 1.0}}));
  // Half of 4 times the steady power heats this coil by 200 limits a second: 64 frames are 0.27 of it.
  const HeatLimits quick{.watts_at_full_scale = 4, .watts_for_ever = 1, .coil_time = 10_ms};
  CHECK(test::summary(check({.heat = quick})) == "OutOfRange");
  CHECK(check({.ceiling = 0.5, .heat = quick}).has_value());
  CHECK_FALSE(check({.excursion = ExcursionLimits{.metres = 1e-3, .metres_at_full_scale = kNan}}));
  CHECK_FALSE(check({.dc = {.level = 0.0}}));
  CHECK_FALSE(check({.dc = {.level = 0.1, .time = Seconds{-1.0}}}));
  CHECK(check(conservative_limits()).has_value());
}
