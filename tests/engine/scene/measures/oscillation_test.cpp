#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "engine/scene/measures/motion.h"

using namespace tactus;

namespace {

/// A e^-at cos(2 pi f t + 0.3), 0.2 s at 48 kHz.
std::vector<double> ringing(double hz, double decay) {
  std::vector<double> samples;
  for (int n = 0; n < 9600; ++n) {
    const double t = n / 48000.0;
    samples.push_back(0.7 * std::exp(-decay * t) * std::cos(2 * std::numbers::pi * hz * t + 0.3));
  }
  return samples;
}

}  // namespace

TEST_CASE("oscillation: the frequency of a sine, between samples", "[analysis]") {
  // At 5 kHz (w T)^9 / 1000 is 2e-5 of a radian, in 1000 periods of them.
  const double hz = GENERATE(40.0, 441.0, 1000.0, 5000.0);
  CHECK(*frequency_of(ringing(hz, 0.0), 48_kHz) == Approx(hz).epsilon(hz > 2000.0 ? 6e-9 : 1e-11));
}

TEST_CASE("oscillation: the frequency of a ringing, whose middle is none", "[analysis]") {
  // Damping ratios d of 1e-3 and 3e-3: the middle is off by d pi / 2, and by the 2 % that the first top
  // lacks, which would move a rise by as much of a radian. What is left of that, d^2 times it, lies in 500
  // radians.
  const auto [hz, decay] = GENERATE(table<double, double>({{441.0, 2.8}, {441.0, 8.3}, {1000.0, 6.3}}));
  CHECK(*frequency_of(ringing(hz, decay), 48_kHz) == Approx(hz).epsilon(1e-8));
}

TEST_CASE("oscillation: the decay of a ringing", "[analysis]") {
  CHECK(*decay_of(ringing(441.0, 12.0), 48_kHz) == Approx(12.0).epsilon(1e-4));
}

TEST_CASE("oscillation: what does not oscillate has neither", "[analysis]") {
  const std::vector<double> flat(100, 1.0);
  CHECK_FALSE(frequency_of(flat, 48_kHz).has_value());
  CHECK_FALSE(decay_of(flat, 48_kHz).has_value());
  CHECK_FALSE(frequency_of({}, 48_kHz).has_value());
}

TEST_CASE("oscillation: the slope of a straight line", "[analysis]") {
  std::vector<double> line;
  for (int n = 0; n < 50; ++n) line.push_back(3.0 - 0.25 * n / 48000.0);
  CHECK(*slope_of(line, 48_kHz) == Approx(-0.25).epsilon(1e-8));
}

TEST_CASE("oscillation: a thrown body falls through 0 when it must, whatever it does then", "[analysis]") {
  // 1 mm up, from rest: sqrt(2 h / g) = 14.2784 ms; behind it the samples rest at -1.
  std::vector<double> height;
  for (int n = 0; n < 1000; ++n) {
    const double t = n / 48000.0, h = 1e-3 - 0.5 * 9.81 * t * t;
    height.push_back(h > 0.0 ? h : -1.0);
  }
  const auto falls = falls_through_zero(height, 48_kHz);
  REQUIRE(falls.size() == 1);
  CHECK(falls[0] == Approx(std::sqrt(2e-3 / 9.81)).epsilon(1e-8));
}

TEST_CASE("oscillation: what bounces between two samples falls through 0 when it must", "[analysis]") {
  // A ball that bounces in no time: falls after sqrt(2 h / g) and then every 2 sqrt(2 h / g).
  const double fall = std::sqrt(2e-3 / 9.81);
  std::vector<double> height;
  for (int n = 0; n < 5000; ++n) {
    const double since = std::fmod(n / 48000.0 + fall, 2 * fall) - fall;
    height.push_back(std::max(1e-12, 1e-3 - 0.5 * 9.81 * since * since));
  }
  const auto falls = falls_through_zero(height, 48_kHz);
  REQUIRE(falls.size() == 4);
  for (std::size_t i = 0; i < falls.size(); ++i)
    CHECK(falls[i] == Approx(fall * (1.0 + 2.0 * static_cast<double>(i))).epsilon(1e-8));
}

TEST_CASE("oscillation: what turns smoothly above 0 does not fall through it", "[analysis]") {
  // Down to a millionth, where the samples beside are 3e-5 up.
  std::vector<double> height;
  for (int n = 0; n < 4800; ++n)
    height.push_back(1.0 + 1e-6 - std::cos(2 * std::numbers::pi * 97.0 * (n + 0.37) / 48000.0));
  CHECK(falls_through_zero(height, 48_kHz).empty());
}
