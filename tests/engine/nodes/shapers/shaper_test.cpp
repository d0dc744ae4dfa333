#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "tests/support/graphs/node_runner.h"

using namespace tactus;
using test::Samples;

namespace {

Samples shape(const char* shape, const Samples& in, double drive = 1, double level = 1) {
  test::NodeRunner runner(test::node_type("shaper"), {{"in", in}, {"drive", drive}, {"level", level}},
                          {{"shape", shape}});
  REQUIRE(runner.error().empty());
  return runner.run(test::random_cutting(static_cast<int>(in.size()), 2))[0];
}

}  // namespace

TEST_CASE("shaper: at rest it gives its function", "[nodes]") {
  CHECK(shape("tanh", {0.7, 0.7})[1] == Approx(std::tanh(0.7)).epsilon(1e-14));
  CHECK(shape("soft", {0.6, 0.6})[1] == Approx(0.6 - 4.0 / 27 * 0.6 * 0.6 * 0.6).epsilon(1e-14));
  CHECK(shape("soft", {9, 9})[1] == 1);
  CHECK(shape("hard", {-3, -3})[1] == -1);
  CHECK(shape("fold", {2, 2})[1] == Approx(std::sin(2)).epsilon(1e-14));
  // Slope `drive` for small signals, `level` at most.
  CHECK(shape("tanh", {1e-6, 1e-6}, 5, 2)[1] == Approx(5e-6).epsilon(1e-9));
  CHECK(shape("tanh", {100, 100}, 5, 2)[1] == Approx(2));
}

TEST_CASE("shaper: between two samples it gives the mean of its function", "[nodes]") {
  CHECK(shape("hard", {0.5, 1.5})[1] == Approx((0.375 + 0.5)));  // 0.5 up to 1, then 1
  CHECK(shape("fold", {1, 3})[1] == Approx((std::cos(1) - std::cos(3)) / 2));
  CHECK(shape("tanh", {-1, 2})[1] == Approx(std::log(std::cosh(2) / std::cosh(1)) / 3));
  CHECK(shape("soft", {1, 2})[1] == Approx((1.125 - 0.1875 - (0.5 - 1 / 27.0)) + 0.5));
}

TEST_CASE("shaper: no digits are lost between samples that are close", "[nodes]") {
  for (const char* name : {"tanh", "soft", "hard", "fold"})
    for (const double at : {0.3, 3.0, 300.0})
      for (const double apart : {1e-12, 1e-7, 0.99e-5, 1.01e-5, 1e-4}) {
        INFO(name << " at " << at << ", " << apart << " apart");
        const double middle = shape(name, {at + apart / 2, at + apart / 2})[1];
        // The mean differs from the middle by apart^2 / 24 of the curvature, at most 1.
        CHECK(std::abs(shape(name, {at, at + apart})[1] - middle) < apart * apart / 24 + 1e-9);
      }
}

TEST_CASE("shaper: aliases of a clipped sine are suppressed by at least 12 dB", "[nodes]") {
  // 7 periods in 64 frames: partials 3 and 9 of the clipped wave lie at bins 21 and 63, which comes back
  // at 1.
  constexpr int kFrames = 64 * 20;
  Samples in;
  for (int n = 0; n < kFrames; ++n) in.push_back(10 * std::sin(2 * std::numbers::pi * 7 * n / 64));
  const auto amplitude_at_bin_one = [](const Samples& samples) {
    double re = 0, im = 0;
    for (int n = kFrames - 64; n < kFrames; ++n) {
      re += samples[static_cast<std::size_t>(n)] * std::cos(2 * std::numbers::pi * n / 64) / 32;
      im += samples[static_cast<std::size_t>(n)] * std::sin(2 * std::numbers::pi * n / 64) / 32;
    }
    return std::hypot(re, im);
  };
  Samples naive;
  for (const double x : in) naive.push_back(std::clamp(x, -1.0, 1.0));
  CHECK(amplitude_at_bin_one(shape("hard", in)) < 0.25 * amplitude_at_bin_one(naive));
}

TEST_CASE("crossfade: linear and with equal power", "[nodes]") {
  const auto fade = [](const char* law, double position) {
    test::NodeRunner runner(test::node_type("crossfade"),
                            {{"a", 2.0}, {"b", -1.0}, {"position", Samples{position}}}, {{"law", law}});
    return runner.run(std::vector{1})[0][0];
  };
  CHECK(fade("linear", 0.25) == 1.25);
  CHECK(fade("linear", 7) == -1);
  CHECK(fade("equal_power", 0.5) == Approx(std::numbers::sqrt2 / 2));
  CHECK(fade("equal_power", 0) == 2);
  CHECK(fade("equal_power", 1) == Approx(-1));
}
