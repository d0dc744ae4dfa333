#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <complex>

#include "engine/dsp/delays/taps_kernel.h"

namespace {

/// Through Order + 1 taps.
template <int Order>
std::array<double, Order + 1> lagrange_weights(double t) {
  std::array<double, Order + 1> w{};
  tactus_lagrange(w.data(), Order + 1, t);
  return w;
}

template <int Order>
double read_power(double t, int power) {
  const auto w = lagrange_weights<Order>(t);
  double sum = 0;
  for (std::size_t k = 0; k < w.size(); ++k) sum += w[k] * std::pow(static_cast<double>(k), power);
  return sum;
}

template <int Order>
double gain(double t, double radians) {
  const auto w = lagrange_weights<Order>(t);
  std::complex<double> sum = 0;
  for (std::size_t k = 0; k < w.size(); ++k) sum += w[k] * std::polar(1.0, -radians * static_cast<double>(k));
  return std::abs(sum);
}

}  // namespace

TEST_CASE("lagrange: polynomials up to the order are read exactly", "[dsp]") {
  for (double t = 0; t <= 5; t += 0.09375) {
    for (int power = 0; power <= 1; ++power)
      CHECK(read_power<1>(t, power) == Approx(std::pow(t, power)).margin(1e-12));
    for (int power = 0; power <= 3; ++power)
      CHECK(read_power<3>(t, power) == Approx(std::pow(t, power)).margin(1e-12));
    for (int power = 0; power <= 5; ++power)
      CHECK(read_power<5>(t, power) == Approx(std::pow(t, power)).margin(1e-10));
  }
}

TEST_CASE("lagrange: on a tap only that tap weighs", "[dsp]") {
  const int tap = GENERATE(0, 1, 2, 3, 4, 5);
  const auto w = lagrange_weights<5>(tap);
  for (int k = 0; k < 6; ++k)
    CHECK(w[static_cast<std::size_t>(k)] == (k == tap ? Approx(1).epsilon(1e-15) : Approx(0).margin(0)));
}

TEST_CASE("lagrange: passive in the middle interval, as a loop needs it", "[dsp]") {
  for (double t = 0; t <= 1; t += 1.0 / 64)
    for (double radians = 0; radians < 3.1416; radians += 0.01) {
      REQUIRE(gain<1>(t, radians) <= 1 + 1e-14);
      REQUIRE(gain<3>(1 + t, radians) <= 1 + 1e-14);
      REQUIRE(gain<5>(2 + t, radians) <= 1 + 1e-14);
    }
}

TEST_CASE("lagrange: within 0.1 dB up to fs/21, fs/8 and fs/6, as the delay's reference says", "[dsp]") {
  constexpr double kTurn = 6.283185307179586;
  const auto db = [](double gain) { return std::abs(20 * std::log10(gain)); };
  for (double t = 0; t <= 1; t += 1.0 / 64) {
    REQUIRE(db(gain<1>(t, kTurn / 21)) < 0.1);
    REQUIRE(db(gain<3>(1 + t, kTurn / 8)) < 0.1);
    REQUIRE(db(gain<5>(2 + t, kTurn / 6)) < 0.1);
  }
  CHECK(db(gain<5>(2.5, kTurn / 5)) > 0.1);
}
