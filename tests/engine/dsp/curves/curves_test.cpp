#include <catch2/catch.hpp>
#include <cmath>

#include "engine/dsp/curves/curve.h"

using namespace tactus;

namespace {

const CubicCurve::Points kPoints = {{0, 0}, {1, 2}, {1.5, 2.1}, {3, -1}, {4, 0.5}};

tactus_cubic_point at(const CubicCurve& curve, double x) {
  const auto view = curve.view();
  return tactus_cubic_at(&view, x);
}

}  // namespace

TEST_CASE("cubic_curve: goes through its points and is level outside", "[dsp]") {
  const auto curve = GENERATE(CubicCurve::monotone(kPoints), CubicCurve::spline(kPoints));
  for (const auto& [x, y] : kPoints) CHECK(at(curve, x).value == Approx(y).margin(1e-14));
  CHECK(at(curve, -5).value == 0);
  CHECK(at(curve, 9).value == 0.5);
  CHECK(at(curve, -5).slope == 0);
}

TEST_CASE("cubic_curve: slope and curvature are the derivatives", "[dsp]") {
  const auto curve = GENERATE(CubicCurve::monotone(kPoints), CubicCurve::spline(kPoints));
  const double x = GENERATE(0.3, 1.2, 2.9, 3.5);
  const double h = 1e-5;  // truncation h^2 f''' / 6 and rounding 1e-16 / h are both near 1e-10
  CHECK(at(curve, x).slope ==
        Approx((at(curve, x + h).value - at(curve, x - h).value) / (2 * h)).margin(1e-8));
  CHECK(at(curve, x).curvature ==
        Approx((at(curve, x + h).slope - at(curve, x - h).slope) / (2 * h)).margin(1e-8));
}

TEST_CASE("cubic_curve: the spline's slope and curvature are continuous at its points", "[dsp]") {
  const auto spline = CubicCurve::spline(kPoints);
  const double x = GENERATE(1.0, 1.5, 3.0);
  const double h = 1e-9;  // third derivatives here are below 100
  CHECK(at(spline, x - h).slope == Approx(at(spline, x + h).slope).margin(1e-7));
  CHECK(at(spline, x - h).curvature == Approx(at(spline, x + h).curvature).margin(1e-6));
}

TEST_CASE("cubic_curve: the monotone one does not leave the range between neighbours", "[dsp]") {
  const auto curve = CubicCurve::monotone(kPoints);
  for (std::size_t i = 0; i + 1 < kPoints.size(); ++i)
    for (int k = 0; k <= 100; ++k) {
      const double y =
          at(curve, kPoints[i].first + k / 100.0 * (kPoints[i + 1].first - kPoints[i].first)).value;
      REQUIRE(y >= std::min(kPoints[i].second, kPoints[i + 1].second) - 1e-14);
      REQUIRE(y <= std::max(kPoints[i].second, kPoints[i + 1].second) + 1e-14);
    }
}

TEST_CASE("breakpoints: linear, step and exponential between two points", "[dsp]") {
  const Breakpoints::Points points = {{0, 100}, {2, 400}};
  CHECK(Breakpoints(points, TACTUS_CURVE_LINEAR).value(1) == 250);
  CHECK(Breakpoints(points, TACTUS_CURVE_LINEAR).slope(1) == 150);
  CHECK(Breakpoints(points, TACTUS_CURVE_STEP).value(1.999) == 100);
  CHECK(Breakpoints(points, TACTUS_CURVE_STEP).value(2) == 400);
  CHECK(Breakpoints(points, TACTUS_CURVE_EXPONENTIAL).value(1) == Approx(200).epsilon(1e-14));
  CHECK(Breakpoints(points, TACTUS_CURVE_EXPONENTIAL).slope(1) ==
        Approx(200 * std::log(4.0) / 2).epsilon(1e-14));
}

TEST_CASE("breakpoints: two points at one place are a jump", "[dsp]") {
  const Breakpoints jump({{0, 0}, {1, 0}, {1, 5}, {2, 5}}, TACTUS_CURVE_LINEAR);
  CHECK(jump.value(std::nextafter(1.0, 0.0)) == 0);
  CHECK(jump.value(1) == 5);
  CHECK(jump.slope(0.5) == 0);
}

TEST_CASE("breakpoints: says what is wrong with points", "[dsp]") {
  CHECK(Breakpoints::error_in({{0, 1}, {1, 2}}, TACTUS_CURVE_CUBIC) == nullptr);
  CHECK(std::string{Breakpoints::error_in({}, TACTUS_CURVE_LINEAR)} == "there are no points");
  CHECK(std::string{Breakpoints::error_in({{1, 0}, {0, 0}}, TACTUS_CURVE_LINEAR)} ==
        "the points are not in ascending order");
  CHECK(std::string{Breakpoints::error_in({{0, -1}, {1, 1}}, TACTUS_CURVE_EXPONENTIAL)} ==
        "an exponential curve cannot reach or cross zero");
  CHECK(std::string{Breakpoints::error_in({{1, 0}, {1, 2}}, TACTUS_CURVE_CUBIC)} ==
        "two points have the same position, but a smooth curve cannot jump");
}
