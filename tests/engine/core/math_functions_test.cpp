#include "engine/core/math_functions.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <random>
#include <string>
#include <vector>

// The reference is long double, which has 11 bits more; where a compiler gives it none, its own rounding
// counts.

namespace {

namespace math = tactus::math;
using Real = long double;
using Arguments = std::function<double(std::mt19937_64&)>;

constexpr int kRandom = 20000;

double uniform(std::mt19937_64& bits, double low, double high) {
  return low + (high - low) * static_cast<double>(bits() >> 11) * 0x1p-53;
}
Arguments between(double low, double high) {
  return [=](std::mt19937_64& bits) { return uniform(bits, low, high); };
}
/// Of both signs, with exponents of 2 in this range.
Arguments of_sizes(double low, double high) {
  return [=](std::mt19937_64& bits) {
    const double size = std::exp2(uniform(bits, low, high));
    return (bits() & 1) != 0 ? size : -size;
  };
}
Arguments positive(double low, double high) {
  return [=](std::mt19937_64& bits) { return std::abs(of_sizes(low, high)(bits)); };
}

/// How far `got` is from `exact`, in units in the last place of `exact`; below the smallest normal number 0
/// is right.
double error_ulp(double got, Real exact) {
  if (std::abs(exact) < Real(std::numeric_limits<double>::min()))
    return std::abs(got) <= std::numeric_limits<double>::min() ? 0 : 1e9;
  if (std::abs(exact) > Real(std::numeric_limits<double>::max()))
    return got == static_cast<double>(exact) ? 0 : 1e9;
  int exponent = 0;
  std::frexp(static_cast<double>(std::abs(exact)), &exponent);
  return static_cast<double>(std::abs(Real(got) - exact) / std::ldexp(Real{1}, exponent - 53));
}

double worst_ulp(double (*function)(double), Real (*exact)(Real), const std::vector<Arguments>& arguments) {
  std::mt19937_64 bits{1};
  double worst = 0;
  for (const auto& argument : arguments)
    for (int i = 0; i < kRandom; ++i) {
      const double x = argument(bits);
      worst = std::max(worst, error_ulp(function(x), exact(Real(x))));
    }
  return worst;
}

double worst_ulp(double (*function)(double, double), Real (*exact)(Real, Real),
                 const std::vector<std::pair<Arguments, Arguments>>& arguments) {
  std::mt19937_64 bits{1};
  double worst = 0;
  for (const auto& [first, second] : arguments)
    for (int i = 0; i < kRandom; ++i) {
      const double a = first(bits), b = second(bits);
      worst = std::max(worst, error_ulp(function(a, b), exact(Real(a), Real(b))));
    }
  return worst;
}

Real floored_rest(Real a, Real b) {
  const Real rest = std::fmod(a, b);
  return rest != 0 && (rest < 0) != (b < 0) ? rest + b : rest;
}

/// The doubles nearest to multiples of pi / 2, where the reduction loses most.
double near_quarter_turn(std::mt19937_64& bits) {
  return static_cast<double>(Real(std::floor(uniform(bits, -9.5e8, 9.5e8))) *
                             1.57079632679489661923132169163975144L);
}

}  // namespace

TEST_CASE("math_functions: exponentials, logarithms and powers stay within their error", "[core]") {
  CHECK(worst_ulp(math::exp, std::exp, {between(-708, 709.7), between(-2, 2), of_sizes(-1000, 3)}) < 0.9);
  CHECK(worst_ulp(math::tanh, std::tanh, {between(-25, 25), between(-1, 1), of_sizes(-1000, 1000)}) < 2.4);
  const std::vector<Arguments> above_zero{positive(-1021, 1023), between(0.4, 2.5),
                                          between(1 - 1e-6, 1 + 1e-6)};
  CHECK(worst_ulp(math::log, std::log, above_zero) < 0.51);
  CHECK(worst_ulp(math::log2, std::log2, above_zero) < 0.51);
  CHECK(worst_ulp(math::log10, std::log10, above_zero) < 0.51);
  CHECK(worst_ulp(math::pow, std::pow,
                  {{between(0.4, 2.5), between(-700, 700)},
                   {positive(-1021, 1023), between(-1, 1)},
                   {[](auto& bits) { return 1 + of_sizes(-52, -3)(bits); }, of_sizes(-3, 50)},
                   {[](auto& bits) { return std::floor(uniform(bits, -99, -1)); },
                    [](auto& bits) { return std::floor(uniform(bits, -20, 20)); }}}) < 0.9);
}

TEST_CASE("math_functions: circular functions stay within their error up to 1.5e9 rad", "[core]") {
  const std::vector<Arguments> angles{between(-2, 2), between(-1e4, 1e4), between(-1.5e9, 1.5e9),
                                      of_sizes(-1000, 30), near_quarter_turn};
  CHECK(worst_ulp(math::sin, std::sin, angles) < 0.8);
  CHECK(worst_ulp(math::cos, std::cos, angles) < 0.8);
  CHECK(worst_ulp(math::tan, std::tan, angles) < 2.2);
}

TEST_CASE("math_functions: inverse circular functions stay within their error", "[core]") {
  const std::vector<Arguments> sines{between(-1, 1), of_sizes(-1000, 0),
                                     [](auto& bits) { return 1 - positive(-53, 0)(bits); },
                                     [](auto& bits) { return positive(-53, 0)(bits) - 1; }};
  CHECK(worst_ulp(math::asin, std::asin, sines) < 2.1);
  CHECK(worst_ulp(math::acos, std::acos, sines) < 2.4);
  CHECK(worst_ulp(math::atan, std::atan, {between(-3, 3), of_sizes(-1000, 1000)}) < 1.8);
  CHECK(worst_ulp(math::atan2, std::atan2,
                  {{between(-2, 2), between(-2, 2)}, {of_sizes(-1000, 1000), of_sizes(-1000, 1000)}}) < 1.8);
}

TEST_CASE("math_functions: roundings and remainders are those of exact arithmetic", "[core]") {
  CHECK(worst_ulp(math::round, std::round, {between(-4, 4), of_sizes(-3, 60)}) == 0);
  CHECK(worst_ulp(math::mod, floored_rest,
                  {{between(-100, 100), between(-2, 2)},
                   {of_sizes(-20, 20), of_sizes(-20, 20)},
                   {of_sizes(990, 1020), of_sizes(990, 1020)}}) <= 0.5);
  for (const double x : {0.5, 1.5, 2.5, 0.49999999999999994, 4503599627370497.0, 9007199254740993.0}) {
    CHECK(math::round(x) == std::round(x));
    CHECK(math::round(-x) == -std::round(x));
  }
  CHECK(math::mod(-0.25, 1) == 0.75);
  CHECK(math::mod(0.25, -1) == -0.75);
  CHECK(math::mod(-1e-20, 1) == 0);  // not 1, which lies outside of [0, 1)
}

TEST_CASE("math_functions: whole powers of a base have whole logarithms", "[core]") {
  for (int n = -300; n <= 300; ++n) CHECK(math::log10(static_cast<double>(std::pow(10.0L, n))) == n);
  for (int n = -1022; n <= 1023; ++n) CHECK(math::log2(std::ldexp(1.0, n)) == n);
  CHECK(math::exp(0) == 1);
  CHECK(math::pow(3, 4) == 81);
  CHECK(math::pow(-2, 3) == -8);
}

TEST_CASE("math_functions: outside a domain the result is NaN, at a pole infinite, at a limit the limit",
          "[core]") {
  const double infinity = math::kInfinity;
  for (const double y :
       {math::log(-1), math::log2(-1e300), math::asin(1.5), math::acos(-1.0000000000000002),
        math::pow(-2, 0.5), math::mod(1, 0), math::sin(infinity), math::exp(math::kNotANumber)})
    CHECK(std::isnan(y));
  CHECK(math::log(0) == -infinity);
  CHECK(math::pow(0, -1) == infinity);
  CHECK(math::exp(710) == infinity);
  CHECK(math::exp(-1e300) == 0);
  CHECK(math::exp(-infinity) == 0);
  CHECK(math::tanh(infinity) == 1);
  CHECK(math::atan(-infinity) == -math::atan(infinity));
  CHECK(math::pow(0, 0) == 1);
  CHECK(math::pow(1, 1e300) == 1);
  CHECK(math::atan2(0, 0) == 0);
  CHECK(math::atan2(0, -1) == 0x1.921fb54442d18p+1);
  CHECK(math::acos(-1) == 0x1.921fb54442d18p+1);
}

TEST_CASE("math_functions: denormals count as 0, also as results", "[core]") {
  CHECK(math::log(5e-324) == -math::kInfinity);
  CHECK(math::pow(1e-310, 2) == 0);
  CHECK(math::exp(-740) == 0);
  CHECK(math::sin(5e-324) <= 5e-324);
}

TEST_CASE("math_functions: an angle of any size has a sine between -1 and 1", "[core]") {
  std::mt19937_64 bits{1};
  for (int i = 0; i < kRandom; ++i) {
    const double x = of_sizes(30, 1023)(bits);
    CHECK(std::abs(math::sin(x)) <= 1);
    CHECK(std::abs(math::cos(x)) <= 1);
    CHECK(std::isfinite(math::tan(x)));
  }
  CHECK(std::abs(math::sin(math::kLargest)) <= 1);
}
