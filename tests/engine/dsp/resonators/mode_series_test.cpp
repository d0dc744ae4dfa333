#include "engine/dsp/resonators/mode_series.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

using namespace tactus;

namespace {

double square(double x) { return x * x; }

}  // namespace

// Fletcher & Rossing, The Physics of Musical Instruments, 2nd ed., sections 2.14 and 2.15; zeros of Bessel
// functions from Abramowitz & Stegun, table 9.5.
TEST_CASE("mode_series: the ratios of the textbook", "[dsp]") {
  using List = std::vector<double>;
  const auto [series, expected] = GENERATE(table<ModeSeries, List>(
      {{ModeSeries::Harmonic, {1, 2, 3, 4}},
       {ModeSeries::Bar,
        {1, square(7.853204624096 / 4.730040744863), square(10.995607838002 / 4.730040744863),
         square(14.137165491257 / 4.730040744863)}},
       {ModeSeries::ClampedBar,
        {1, square(4.694091132974 / 1.875104068712), square(7.854757438238 / 1.875104068712),
         square(10.995540734875 / 1.875104068712)}},
       {ModeSeries::Membrane,
        {1, 3.8317059702 / 2.4048255577, 5.1356223018 / 2.4048255577, 5.5200781103 / 2.4048255577,
         6.3801618952 / 2.4048255577, 7.0155866698 / 2.4048255577}}}));
  const auto ratios = mode_ratios(series, static_cast<int>(expected.size()), 1);
  REQUIRE(ratios.size() == expected.size());
  for (std::size_t k = 0; k < expected.size(); ++k)
    CHECK(ratios[k] == Approx(expected[k]).epsilon(0).margin(1e-9 * expected[k]));
}

TEST_CASE("mode_series: a geometric series goes in equal ratios from 1 to its span", "[dsp]") {
  const auto ratios = mode_ratios(ModeSeries::Geometric, 9, 16);
  for (std::size_t k = 0; k < 9; ++k)
    CHECK(ratios[k] == Approx(std::exp2(0.5 * static_cast<double>(k))).epsilon(1e-14));
  CHECK(mode_ratios(ModeSeries::Geometric, 1, 16) == std::vector<double>{1});
}

TEST_CASE("mode_series: high modes of bars lie at the squares of odd numbers", "[dsp]") {
  // cos b = +-1 / cosh b is 0 within rounding from the twelfth on.
  const double first = 4.730040744862704;  // cos b cosh b = 1, Abramowitz & Stegun 4.7
  const auto ratios = mode_ratios(ModeSeries::Bar, 400, 1);
  for (std::size_t k = 12; k < ratios.size(); ++k) {
    const double b = (static_cast<double>(k) + 1.5) * std::numbers::pi;
    CHECK(ratios[k] == Approx(b * b / (first * first)).epsilon(1e-13));
  }
}

// Weyl's law with its edge term: of all modes, pairs counted twice, x^2/4 - x/2 lie below x; the x/pi of J_0
// have no twin.
TEST_CASE("mode_series: no mode of a membrane is missing", "[dsp]") {
  const auto ratios = mode_ratios(ModeSeries::Membrane, 600, 1);
  CHECK(std::is_sorted(ratios.begin(), ratios.end()));
  for (const std::size_t count : {100u, 300u, 600u}) {
    const double x = ratios[count - 1] * 2.404825557695773;
    const double expected = (x * x / 4 - x / 2 + x / std::numbers::pi) / 2;
    CHECK(std::abs(static_cast<double>(count) - expected) < 0.02 * expected);
  }
}
