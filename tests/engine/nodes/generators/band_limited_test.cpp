#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <numbers>

#include "tests/support/graphs/node_runner.h"
#include "tests/support/graphs/play_node.h"

using namespace tactus;
using test::Samples;

namespace {

constexpr double kPi = std::numbers::pi, kRate = 48000;
constexpr int kFrames = 1024, kPartials = 3000;

/// What the transform of the cubic B-spline keeps of a partial; of one above half the rate, of its alias.
double kept(double cycles_per_frame) {
  const double x = kPi * cycles_per_frame;
  return x == 0 ? 1 : std::pow(std::sin(x) / x, 4);
}

/// The sum of the partials of a wave, aliases included.
Samples series(double cycles_per_frame, double mean, const std::function<double(int, double)>& partial) {
  Samples samples(kFrames, mean);
  for (int n = 0; n < kFrames; ++n)
    for (int h = 1; h <= kPartials; ++h)
      samples[static_cast<std::size_t>(n)] +=
          kept(h * cycles_per_frame) * partial(h, 2 * kPi * std::fmod(h * cycles_per_frame * n, 1.0));
  return samples;
}

void compare(const char* type, double cycles_per_frame, std::map<std::string, test::InputValue> inputs,
             const Samples& expected) {
  inputs["frequency"] = cycles_per_frame * kRate;
  test::NodeRunner runner(test::node_type(type), inputs);
  REQUIRE(runner.error().empty());
  const auto out = runner.run(test::random_cutting(kFrames, 5))[0];
  double largest = 0;
  for (std::size_t n = 0; n < out.size(); ++n) largest = std::max(largest, std::abs(out[n] - expected[n]));
  INFO(type << " at " << cycles_per_frame);
  // The partials left out: less than 1e-3 of an amplitude below 1e-3.
  CHECK(largest < 1e-6);
}

}  // namespace

TEST_CASE("band-limited waves: every partial has its amplitude times sinc^4, and so has every alias",
          "[nodes][slow]") {
  // In turns a frame, exact in binary: low, above a quarter of the rate, backwards, half the rate.
  const double f = GENERATE(37.0 / 1024, 300.0 / 1024, -37.0 / 1024, 0.5);
  compare("saw", f, {}, series(f, 0, [](int h, double x) { return -2 / (kPi * h) * std::sin(x); }));
  compare("square", f, {{"width", 0.25}}, series(f, -0.5, [](int h, double x) {
            return 4 / (kPi * h) * std::sin(kPi * h * 0.25) * std::cos(x - kPi * h * 0.25);
          }));
  compare("triangle", f, {}, series(f, 0, [](int h, double x) {
            if (h % 2 == 0) return 0.0;
            return (h % 4 == 1 ? 8 : -8) / (kPi * kPi * h * h) * std::sin(x);
          }));
}

TEST_CASE("band-limited waves: level and phase are those of a sine", "[nodes]") {
  for (const char* type : {"saw", "square", "triangle"}) {
    const auto play = [type](double phase, double level) {
      return test::play_node(test::node_type(type), 64,
                             {{"frequency", 750.0}, {"phase", phase}, {"level", level}});
    };
    const auto plain = play(0, 1), late = play(-kPi / 4, 1), loud = play(0, 3);
    // An eighth of a period of 64 frames.
    for (std::size_t n = 8; n < plain.size(); ++n) {
      CHECK(late[n] == Approx(plain[n - 8]).margin(1e-12));
      CHECK(loud[n] == Approx(3 * plain[n]).margin(1e-12));
    }
  }
}

TEST_CASE("phasor: a ramp from 0 to 1, which a trigger starts again", "[nodes]") {
  Samples reset(12);
  reset[5] = 1;
  CHECK(test::play_node(test::node_type("phasor"), 12, {{"frequency", 12000.0}, {"reset", reset}}) ==
        Samples{0, 0.25, 0.5, 0.75, 0, 0, 0.25, 0.5, 0.75, 0, 0.25, 0.5});
  CHECK(test::play_node(test::node_type("phasor"), 5, {{"frequency", -12000.0}, {"phase", kPi}}) ==
        Samples{0.5, 0.25, 0, 0.75, 0.5});
}

TEST_CASE("random walk: spreads as diffusion does, and stays between its ends", "[nodes]") {
  constexpr int kLong = 400'000;
  const auto walk = [](double time, const char* seed) {
    test::NodeRunner runner(test::node_type("random_walk"), {{"time", time}, {"level", 2.0}},
                            {{"seed", seed}});
    return runner.run(test::even_cutting(kLong, 64))[0];
  };
  SECTION("mean square of a step: level^2 / (rate time)") {
    const auto slow = walk(10, "3");
    double sum = 0;
    for (std::size_t n = 1; n < slow.size(); ++n) sum += (slow[n] - slow[n - 1]) * (slow[n] - slow[n - 1]);
    // Relative standard deviation of the mean: sqrt(2 / 400000) = 0.22 %.
    CHECK(sum / (kLong - 1) == Approx(4 / (kRate * 10)).epsilon(0.01));
  }
  SECTION("in the long run all values are equally likely: mean 0, variance level^2 / 3") {
    const auto fast = walk(0.001, "4");
    double mean = 0, square = 0;
    for (const double x : fast) {
      CHECK_FALSE(std::abs(x) > 2);
      mean += x / kLong;
      square += x * x / kLong;
    }
    // Some 8000 independent values: 4 / 2.2 % and 1.3 %.
    CHECK(mean == Approx(0).margin(4 * 1.155 / std::sqrt(8000)));
    CHECK(square == Approx(4.0 / 3).epsilon(0.05));
  }
  SECTION("another seed is another walk") { CHECK(walk(0.1, "1") != walk(0.1, "2")); }
}
