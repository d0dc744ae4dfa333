#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "engine/dsp/curves/curve_kernel.h"
#include "engine/dsp/generators/counter_noise.h"
#include "engine/nodes/generators/oscillator_kernel.h"
#include "engine/nodes/generators/sample_kernel.h"

using namespace tactus;

namespace {

constexpr double kTwoPi = 6.283185307179586;

double worst_table_error(std::size_t size, bool cubic) {
  std::vector<double> period(size);
  for (std::size_t i = 0; i < size; ++i)
    period[i] = std::sin(kTwoPi * static_cast<double>(i) / static_cast<double>(size));
  double worst = 0;
  for (int i = 0; i <= 5000; ++i) {
    const double turns = i / 5000.0;
    worst =
        std::max(worst, std::abs(tactus_wavetable_at(period.data(), static_cast<int>(size), turns, cubic) -
                                 std::sin(kTwoPi * turns)));
  }
  return worst;
}

}  // namespace

TEST_CASE("phasor: a million frames later the phase is still n f / rate", "[dsp]") {
  tactus_phasor phasor{};
  const double increment = 440.0 / 48000.0;
  double phase = 0;
  for (int n = 0; n <= 1'000'000; ++n) phase = tactus_phasor_step(&phasor, increment);
  // 440e6 / 48000 = 9166.666... turns; each frame rounds by at most 1.2e-16 of a turn.
  CHECK(phase == Approx(2.0 / 3.0).margin(1.2e-10));
}

TEST_CASE("phasor: stays in 0 to 1 backwards and by steps too small to see", "[dsp]") {
  const double increment = GENERATE(-0.3, -1e-20, 1e-20, 1e30, -7.75);
  tactus_phasor phasor{};
  bool inside = true;
  for (int n = 0; n < 1000; ++n) {
    const double phase = tactus_phasor_step(&phasor, increment);
    inside = inside && phase >= 0 && phase < 1;
  }
  CHECK(inside);
}

TEST_CASE("counter_noise: moments and correlations are those of white noise", "[dsp]") {
  constexpr int kCount = 200'000;
  const CounterNoise noise(1, 0), other_lane(1, 1), other_seed(2, 0);
  double mean = 0, square = 0, next = 0, lane = 0, seed = 0, normal = 0, normal_square = 0, normal_fourth = 0;
  for (int n = 0; n < kCount; ++n) {
    const double u = noise.uniform(n), g = noise.gaussian(n);
    mean += u / kCount;
    square += u * u / kCount;
    next += u * noise.uniform(n + 1) / kCount;
    lane += u * other_lane.uniform(n) / kCount;
    seed += u * other_seed.uniform(n) / kCount;
    normal += g / kCount;
    normal_square += g * g / kCount;
    normal_fourth += g * g * g * g / kCount;
  }
  // Five standard deviations of each estimate.
  const double root = std::sqrt(double{kCount});
  CHECK(mean == Approx(0).margin(5 * std::sqrt(1.0 / 3) / root));
  CHECK(square == Approx(1.0 / 3).margin(5 * std::sqrt(4.0 / 45) / root));
  CHECK(next == Approx(0).margin(5.0 / 3 / root));
  CHECK(lane == Approx(0).margin(5.0 / 3 / root));
  CHECK(seed == Approx(0).margin(5.0 / 3 / root));
  CHECK(normal == Approx(0).margin(5 / root));
  CHECK(normal_square == Approx(1).margin(5 * std::sqrt(2.0) / root));
  CHECK(normal_fourth == Approx(3).margin(5 * std::sqrt(96.0) / root));
}

TEST_CASE("catmull_rom: exact for a parabola", "[dsp]") {
  const auto f = [](double x) { return 2 * x * x - 3 * x + 0.5; };
  const double at = GENERATE(0.0, 0.25, 0.7, 1.0);
  CHECK(tactus_catmull_rom(f(-1), f(0), f(1), f(2), at) == Approx(f(at)).margin(1e-14));
}

TEST_CASE("wavetable: a sine is read back within the error of the interpolation", "[dsp]") {
  // Linear: (2 pi / N)^2 / 8 at most. Cubic: at least third order, so an eighth for twice the numbers.
  CHECK(worst_table_error(64, false) <= std::pow(kTwoPi / 64, 2) / 8 * (1 + 1e-9));
  CHECK(worst_table_error(64, true) < worst_table_error(32, true) / 8);
  CHECK(worst_table_error(1, true) == Approx(1).margin(1e-6));  // one number: a constant, here 0
}

TEST_CASE("sample: plays each sample once, then silence", "[dsp]") {
  const std::vector<double> recording = {1, -2, 3};
  const bool cubic = GENERATE(false, true);
  tactus_sample player{};
  CHECK(tactus_sample_read(&player, recording.data(), 3, 1, cubic) == 0);
  tactus_sample_start(&player);
  for (const double expected : {1.0, -2.0, 3.0, 0.0, 0.0})
    CHECK(tactus_sample_read(&player, recording.data(), 3, 1, cubic) == expected);
}

TEST_CASE("sample: at half speed the values between are the means", "[dsp]") {
  const std::vector<double> recording = {1, -2, 3};
  tactus_sample player{};
  tactus_sample_start(&player);
  for (const double expected : {1.0, -0.5, -2.0, 0.5, 3.0, 1.5, 0.0})
    CHECK(tactus_sample_read(&player, recording.data(), 3, 0.5, 0) == expected);
}
