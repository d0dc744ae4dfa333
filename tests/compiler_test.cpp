#include <array>
#include <catch2/catch.hpp>
#include <cstring>
#include <vector>

// What the rest takes for granted of the compiler and its flags. Each once was not so.

namespace {

// Reads that the compiler may not foresee: it would then also foresee the test.
double weighted(const double* values, int count) {
  volatile double sum = 0;
  for (int i = 0; i < count; ++i) {
    volatile double value = values[i];
    sum = sum + value * (1 << (4 * i));
  }
  return sum;
}

[[gnu::noinline]] std::vector<double> ones_then_zeros() { return {1.0, 1.0, 0.0, 0.0}; }
[[gnu::noinline]] std::vector<double> three_and_a_zero() { return {2.0, 2.0, 2.0, 0.0}; }
[[gnu::noinline]] void copy_constant(double* out) {
  static constexpr double kConstant[] = {1, 1, 1, 1, 0, 0, 0, 0};
  std::memcpy(out, kConstant, sizeof kConstant);
}

}  // namespace

TEST_CASE("compiler: a constant that ends in zeros keeps them", "[compiler]") {
  CHECK(weighted(ones_then_zeros().data(), 4) == 0x0011);
  CHECK(weighted(three_and_a_zero().data(), 4) == 0x0222);
  std::array<double, 8> copied{};
  copy_constant(copied.data());
  CHECK(weighted(copied.data(), 7) == 0x0001111);
}

TEST_CASE("compiler: does not fuse a multiplication with an addition on its own", "[compiler]") {
  // (1 + 2^-30)^2 = 1 + 2^-29 + 2^-60; rounding the product first loses 2^-60, fusing keeps it.
  volatile double a = 1.0 + 0x1p-30;
  const double x = a;
  const double y = -(1.0 + 0x1p-29);
  CHECK(x * x + y == 0.0);
}
