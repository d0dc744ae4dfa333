#include "engine/dsp/filters/recurrence.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <random>
#include <vector>

#include "tests/support/graphs/node_runner.h"

using namespace tactus;
using namespace tactus::test;

namespace {

using Signal = std::vector<double>;
constexpr int kFrames = 3000;

/// Coefficients of a group: a stable pair of poles that wanders.
std::array<double, 2> poles_of(std::int64_t group, bool modulated) {
  const double radius = modulated ? 0.9 + 0.09 * std::sin(0.37 * static_cast<double>(group)) : 0.99;
  const double angle = modulated ? 0.2 + 0.1 * std::cos(0.21 * static_cast<double>(group)) : 0.3;
  return {2 * radius * std::cos(angle), -radius * radius};
}

template <int Order>
std::array<double, Order> coefficients(std::int64_t group, bool modulated) {
  const auto a = poles_of(group, modulated);
  if constexpr (Order == 2)
    return a;
  else
    return {a[0] / 2};
}

template <int Order>
Signal in_blocks(const Signal& v, std::span<const int> lengths, std::int64_t first_frame, bool modulated) {
  Recurrence<Order> recurrence;
  Signal y(v.size());
  int from = 0;
  for (int length : lengths)
    while (length > 0) {
      const auto frame = first_frame + from;
      const int position = group_position(frame);
      if (position == 0 || from == 0)
        recurrence.design(coefficients<Order>(frame / kGroup, modulated).data());
      const int run = modulated ? std::min(length, kGroup - position) : length;
      recurrence.run(v.data() + from, y.data() + from, run, position);
      from += run, length -= run;
    }
  return y;
}

template <int Order>
std::vector<long double> direct(const Signal& v, std::int64_t first_frame, bool modulated) {
  std::vector<long double> y(v.size());
  for (std::size_t n = 0; n < v.size(); ++n) {
    const auto a = coefficients<Order>((first_frame + static_cast<std::int64_t>(n)) / kGroup, modulated);
    y[n] = static_cast<long double>(v[n]);
    for (std::size_t i = 0; i < Order && i < n; ++i) y[n] += static_cast<long double>(a[i]) * y[n - 1 - i];
  }
  return y;
}

template <int Order>
void check_against_direct(bool modulated, std::int64_t first_frame) {
  const auto v = noise(kFrames, 1);
  const auto y = in_blocks<Order>(v, even_cutting(kFrames, 64), first_frame, modulated);
  const auto expected = direct<Order>(v, first_frame, modulated);
  long double largest = 0, error = 0;
  for (std::size_t n = 0; n < y.size(); ++n) {
    largest = std::max(largest, std::abs(expected[n]));
    error = std::max(error, std::abs(expected[n] - static_cast<long double>(y[n])));
  }
  CHECK(static_cast<double>(error / largest) < 1e-13);
}

template <int Order>
void check_cuttings(const Signal& v, bool modulated, std::int64_t first_frame) {
  const Outputs whole{in_blocks<Order>(v, std::vector{kFrames}, first_frame, modulated)};
  for (unsigned seed = 0; seed < 20; ++seed) {
    const auto lengths = random_cutting(kFrames, seed, seed % 2 ? 64 : 10);
    CHECK(first_difference(whole, {in_blocks<Order>(v, lengths, first_frame, modulated)}) == "");
  }
  CHECK(first_difference(whole, {in_blocks<Order>(v, even_cutting(kFrames, 1), first_frame, modulated)}) ==
        "");
}

}  // namespace

TEST_CASE("recurrence: equals the direct form in long double within 1e-13", "[dsp]") {
  const bool modulated = GENERATE(false, true);
  const std::int64_t first_frame = GENERATE(0, 3, 8000005);
  check_against_direct<1>(modulated, first_frame);
  check_against_direct<2>(modulated, first_frame);
}

TEST_CASE("recurrence: any cutting into blocks gives the same bits", "[dsp]") {
  const bool modulated = GENERATE(false, true);
  const std::int64_t first_frame = GENERATE(0, 5);
  auto v = noise(kFrames, 2);
  SECTION("noise") {}
  SECTION("zeros of both signs, where a lane to come adds 0 * x") {
    for (std::size_t n = 0; n < v.size(); ++n) v[n] = n % 3 == 0 ? 0.0 : -0.0;
  }
  SECTION("sparse negative impulses that fade into the denormals") {
    for (std::size_t n = 0; n < v.size(); ++n) v[n] = n % 50 == 0 ? -1e-300 : -0.0;
  }
  check_cuttings<1>(v, modulated, first_frame);
  check_cuttings<2>(v, modulated, first_frame);
}

TEST_CASE("recurrence: any cutting gives the same bits with denormals off", "[dsp]") {
  const NoDenormals off;
  auto v = noise(kFrames, 3, -1e-305, 1e-305);
  check_cuttings<1>(v, false, 0);
  check_cuttings<2>(v, true, 3);
}

TEST_CASE("recurrence: the impulse response of one pole is its powers", "[dsp]") {
  Recurrence<1> recurrence;
  constexpr double kHalf = 0.5;  // exact in binary
  recurrence.design(&kHalf);
  auto v = impulse(40);
  Signal y(v.size());
  recurrence.run(v.data(), y.data(), 40, 0);
  for (std::size_t n = 0; n < y.size(); ++n) CHECK(y[n] == std::pow(0.5, static_cast<double>(n)));
}
