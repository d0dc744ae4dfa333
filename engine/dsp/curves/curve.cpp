#include "engine/dsp/curves/curve.h"

#include <cstddef>

namespace tactus {

CubicCurve::CubicCurve(const Points& points) : slope_(points.size(), 0.0) {
  for (const auto& [x, y] : points) {
    x_.push_back(x);
    value_.push_back(y);
  }
}

CubicCurve CubicCurve::monotone(const Points& points) {
  CubicCurve curve(points);
  for (std::size_t i = 1; i + 1 < points.size(); ++i) {
    const double left_width = curve.x_[i] - curve.x_[i - 1];
    const double right_width = curve.x_[i + 1] - curve.x_[i];
    const double left = (curve.value_[i] - curve.value_[i - 1]) / left_width;
    const double right = (curve.value_[i + 1] - curve.value_[i]) / right_width;
    if (!(left * right > 0)) continue;  // a peak or a valley: level
    const double a = 2 * right_width + left_width;
    const double b = right_width + 2 * left_width;
    curve.slope_[i] = (a + b) / (a / left + b / right);
  }
  return curve;
}

CubicCurve CubicCurve::spline(const Points& points) {
  CubicCurve curve(points);
  const std::size_t count = points.size();
  if (count < 3) return curve;
  // Equal second derivatives at each inner point: a tridiagonal system for the slopes, solved by elimination.
  std::vector<double> factor(count, 0.0);
  for (std::size_t i = 1; i + 1 < count; ++i) {
    const double left = 1.0 / (curve.x_[i] - curve.x_[i - 1]);
    const double right = 1.0 / (curve.x_[i + 1] - curve.x_[i]);
    const double curvature = 3.0 * ((curve.value_[i] - curve.value_[i - 1]) * left * left +
                                    (curve.value_[i + 1] - curve.value_[i]) * right * right);
    const double pivot = 2.0 * (left + right) - left * factor[i - 1];
    factor[i] = right / pivot;
    curve.slope_[i] = (curvature - left * curve.slope_[i - 1]) / pivot;
  }
  for (std::size_t i = count - 2; i > 0; --i) curve.slope_[i] -= factor[i] * curve.slope_[i + 1];
  return curve;
}

const char* Breakpoints::error_in(const Points& points, Shape shape) {
  if (points.empty()) return "there are no points";
  for (std::size_t i = 1; i < points.size(); ++i) {
    if (points[i].first < points[i - 1].first) return "the points are not in ascending order";
    if (shape == TACTUS_CURVE_CUBIC && points[i].first == points[i - 1].first)
      return "two points have the same position, but a smooth curve cannot jump";
    if (shape == TACTUS_CURVE_EXPONENTIAL && !(points[i].second * points[0].second > 0))
      return "an exponential curve cannot reach or cross zero";
  }
  return nullptr;
}

}  // namespace tactus
