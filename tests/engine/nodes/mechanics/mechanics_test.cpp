
#include <catch2/catch.hpp>
#include <cmath>

#include "tests/support/graphs/play_node.h"

using namespace tactus;
using test::play_node;
using test::refusal;
using test::Samples;

namespace {

constexpr double kWeight = 2;
const std::string kProfile =
    "[[-0.008, 0.001], [-0.005, 0.0005], [-0.001, 0.002], [0.002, -0.001], [0.006, 0]]";

/// Force and height at many places.
test::Outputs feel(const std::string& profile, const Samples& places) {
  test::NodeRunner runner(test::node_type("terrain"),
                          {{"position", places}, {"weight", kWeight}, {"height", 0.001}, {"length", 0.002}},
                          {{"profile", profile}, {"points", kProfile}});
  return runner.run(test::even_cutting(static_cast<int>(places.size()), 64));
}

Samples places(double from, double to, int intervals) {
  Samples x;
  for (int i = 0; i <= intervals; ++i) x.push_back(from + (to - from) * i / intervals);
  return x;
}

}  // namespace

TEST_CASE("terrain: the force is -weight times the slope of the height it shows", "[nodes]") {
  const std::string profile = GENERATE("detent", "sine", "points");
  const double h = 1e-7;
  auto x = places(-0.0075, 0.0055, 400);
  const auto force = feel(profile, x)[0];
  auto ahead = x, behind = x;
  for (auto& a : ahead) a += h;
  for (auto& b : behind) b -= h;
  const auto above = feel(profile, ahead)[1], below = feel(profile, behind)[1];
  double peak = 0, worst = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    peak = std::max(peak, std::abs(force[i]));
    worst = std::max(worst, std::abs(force[i] + kWeight * (above[i] - below[i]) / (2 * h)));
  }
  REQUIRE(peak > 0.1);
  CHECK(worst < 1e-6 * peak);
}

TEST_CASE("terrain: the work over a passage is the weight times the difference of heights", "[nodes]") {
  const std::string profile = GENERATE("detent", "sine", "points");
  // Ends and knots of the points lie on the grid, so that Simpson's rule is exact for the spline.
  const int intervals = 14000;
  const auto x = places(-0.008, 0.006, intervals);
  const auto felt = feel(profile, x);
  double work = 0;
  for (int i = 0; i <= intervals; ++i)
    work += felt[0][static_cast<std::size_t>(i)] * (i == 0 || i == intervals ? 1 : i % 2 == 1 ? 4 : 2);
  work *= 0.014 / intervals / 3;
  CHECK(work == Approx(kWeight * (felt[1].front() - felt[1].back())).margin(1e-9));
}

TEST_CASE("terrain: no force beyond drawn points, and no jump on the way there", "[nodes]") {
  const auto felt = feel("points", {-0.1, -0.008 + 1e-12, 0.006 - 1e-12, 0.1});
  for (const double force : felt[0]) CHECK(force == Approx(0).margin(1e-7));
  CHECK(felt[1].front() == 0.001);
}

TEST_CASE("terrain: a detent is a spring of weight height / length^2 near its centre", "[nodes]") {
  test::NodeRunner runner(test::node_type("terrain"), {{"position", 0.0}});
  const double at[] = {0, kWeight, 0.001, 0.002};
  CHECK(runner.node().response(0, 0, on_circle(10_Hz, 48_kHz), at)->real() ==
        Approx(-kWeight * 0.001 / (0.002 * 0.002)).epsilon(1e-14));
}

TEST_CASE("terrain: points are asked for when the profile is made of them", "[nodes]") {
  CHECK(refusal(test::node_type("terrain"), {{"position", 0.0}}, {{"profile", "points"}}) ==
        "Missing 'points' points");
  CHECK(refusal(test::node_type("terrain"), {{"position", 0.0}},
                {{"profile", "points"}, {"points", "[[1, 0], [0, 0]]"}}) == "BadArgument 'points'");
}

TEST_CASE("wall: pushes out behind its place, more when driven in, never pulls", "[nodes]") {
  const auto out = play_node(test::node_type("wall"), 4,
                             {{"position", Samples{0.01, 0.03, 0.03, 0.03}},
                              {"velocity", Samples{5, 0, 0.5, -100}},
                              {"stiffness", 800.0},
                              {"damping", 2.0},
                              {"at", 0.02}});
  const Samples expected = {0, -8, -9, 0};
  for (std::size_t i = 0; i < 4; ++i) CHECK(out[i] == Approx(expected[i]).margin(1e-14));
}

TEST_CASE("spring, damper: F = -k (x - rest), F = -b v", "[nodes]") {
  CHECK(play_node(test::node_type("spring"), 2,
                  {{"in", Samples{0.5, -0.5}}, {"stiffness", 8.0}, {"rest", 0.25}}) == Samples{-2, 6});
  CHECK(play_node(test::node_type("damper"), 2, {{"in", Samples{2, -4}}, {"damping", 0.5}}) ==
        Samples{-1, 2});
}

TEST_CASE("actuator_inverse: its voltage moves the coil of the equations along the plan", "[nodes]") {
  // The plan: 2 mm to and fro at 20 Hz. The coil of the shipped woofer, integrated in steps of 1/16 frame.
  constexpr double kRate = 48000, kR = 6.5, kL = 0.8e-3, kBl = 6, kMass = 0.035, kLoss = 1.2, kSpring = 1000;
  constexpr int kFrames = 9600, kSteps = 16;
  Samples plan;
  for (int n = 0; n < kFrames; ++n) {
    const double w = 2 * M_PI * 20, t = n / kRate;
    plan.push_back(2e-3 * w * std::sin(w * t) * std::min(1.0, t / 0.05));
  }
  test::NodeRunner runner(test::node_type("actuator_inverse"), {{"velocity", plan},
                                                                {"resistance", kR},
                                                                {"inductance", kL},
                                                                {"force_factor", kBl},
                                                                {"mass", kMass},
                                                                {"damping", kLoss},
                                                                {"stiffness", kSpring},
                                                                {"centring", 1000.0}});
  const auto out = runner.run(test::even_cutting(kFrames, 64));
  double x = 0, v = 0, i = 0, apart = 0;
  for (int n = 0; n < kFrames; ++n) {
    for (int k = 0; k < kSteps; ++k) {
      const double dt = 1 / (kRate * kSteps);
      i += dt * (out[0][static_cast<std::size_t>(n)] - kR * i - kBl * v) / kL;
      v += dt * (kBl * i - kLoss * v - kSpring * x) / kMass;
      x += dt * v;
    }
    if (n > kFrames / 2) apart = std::max(apart, std::abs(v - out[1][static_cast<std::size_t>(n)]));
  }
  CHECK(apart < 0.01 * 2e-3 * 2 * M_PI * 20);
}
