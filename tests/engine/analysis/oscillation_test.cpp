#include "engine/analysis/oscillation.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

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
  const double hz = GENERATE(40.0, 441.0, 1000.0);
  // (w T)^4 / 100 of a period in two rises: at 1 kHz 3e-6 of one of 200 periods.
  CHECK(*frequency_of(ringing(hz, 0.0), 48_kHz) == Approx(hz).epsilon(1e-7));
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
  CHECK(*slope_of(line, 48_kHz) == Approx(-0.25).epsilon(1e-9));
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
  CHECK(falls[0] == Approx(std::sqrt(2e-3 / 9.81)).epsilon(1e-9));
}
