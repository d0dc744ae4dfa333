#include "latency/estimation/delay_trend.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

using namespace tactus;

namespace {

std::vector<DelayPoint> line(double slope, int count = 10) {
  std::vector<DelayPoint> points;
  for (int n = 0; n < count; ++n) points.push_back({n * 20000, 500.0 + slope * n * 20000});
  return points;
}

}  // namespace

TEST_CASE("delay_trend: a line is found exactly", "[latency]") {
  const auto trend = DelayTrend::of(line(50e-6), 0.75);
  CHECK(trend.slope == Approx(50e-6));
  CHECK(trend.slope_deviation < 1e-12);
  CHECK(trend.steps.empty());
  CHECK(trend.longest.size() == 10);
}

TEST_CASE("delay_trend: jumps do not bend the line", "[latency]") {
  auto points = line(50e-6);
  for (std::size_t n = 3; n < points.size(); ++n) points[n].delay_frames -= 256.0;
  for (std::size_t n = 8; n < points.size(); ++n) points[n].delay_frames += 64.0;
  const auto trend = DelayTrend::of(points, 0.75);
  CHECK(trend.slope == Approx(50e-6));
  REQUIRE(trend.steps.size() == 2);
  CHECK(trend.steps[0].frame == 60000);
  CHECK(trend.steps[0].frames == Approx(-256.0));
  CHECK(trend.steps[1].frames == Approx(64.0));
  CHECK(trend.longest == std::vector<std::size_t>{3, 4, 5, 6, 7});
}

TEST_CASE("delay_trend: the slope's error is that of least squares", "[latency]") {
  auto points = line(0.0, 4);
  points[1].delay_frames += 0.1;
  points[2].delay_frames -= 0.1;
  const auto trend = DelayTrend::of(points, 0.75);
  // times -1.5, -0.5, 0.5, 1.5 (in 20000): slope = (-0.05 - 0.05) / 5; residuals 0.03, 0.09 and mirrored
  CHECK(trend.slope * 20000 == Approx(-0.02).epsilon(0).margin(1e-9));
  const double squares = 2 * (0.03 * 0.03 + 0.09 * 0.09);
  CHECK(trend.slope_deviation * 20000 == Approx(std::sqrt(squares / 2 / 5)).epsilon(1e-6));
}

TEST_CASE("delay_trend: another speed is the same sound, only faster", "[latency]") {
  std::vector<double> samples;
  const double w = 2 * std::numbers::pi * GENERATE(0.01, 0.1, 0.42);
  for (int n = 0; n < 4000; ++n) samples.push_back(std::sin(w * n));
  const double speed = 1.0 + GENERATE(-1e-4, 5e-5, 1e-3);
  const auto faster = at_speed(samples, speed);
  double worst = 0.0;
  for (std::size_t n = 100; n < 3900; ++n)
    worst = std::max(worst, std::abs(faster[n] - std::sin(w * speed * static_cast<double>(n))));
  CHECK(worst < 5e-5);
}
