#include "engine/dsp/curves/breakpoints.h"

#include <algorithm>
#include <cmath>

namespace tactus {

const char* Breakpoints::mistake(const Points& points, Shape shape) {
  if (points.empty()) return "there is no point";
  for (std::size_t i = 1; i < points.size(); ++i) {
    if (points[i].first < points[i - 1].first) return "the points are not in ascending order";
    if (shape == Shape::Smooth && points[i].first == points[i - 1].first)
      return "two points lie at the same place, and a smooth curve cannot jump";
    if (shape == Shape::Exponential && !(points[i].second * points[0].second > 0))
      return "an exponential curve cannot reach or cross zero";
  }
  return nullptr;
}

Breakpoints::Breakpoints(Points points, Shape shape) : points_(std::move(points)), shape_(shape) {
  least_ = most_ = points_.front().second;
  for (const auto& [x, y] : points_) {
    least_ = std::min(least_, y);
    most_ = std::max(most_, y);
  }
  if (shape == Shape::Smooth) smooth_ = CubicCurve::monotone(points_);
}

std::size_t Breakpoints::interval(double x) const {
  const auto next = std::upper_bound(points_.begin(), points_.end(), x,
                                     [](double a, const auto& point) { return a < point.first; });
  return static_cast<std::size_t>(next - points_.begin()) - 1;
}

double Breakpoints::value(double x) const {
  if (outside(x)) return x < points_.front().first ? points_.front().second : points_.back().second;
  if (shape_ == Shape::Smooth) return smooth_->value(x);
  const std::size_t i = interval(x);
  const auto [x0, y0] = points_[i];
  const auto [x1, y1] = points_[i + 1];
  const double at = (x - x0) / (x1 - x0);
  switch (shape_) {
    case Shape::Step:
      return y0;
    case Shape::Exponential:
      return y0 * std::pow(y1 / y0, at);
    default:
      return y0 + at * (y1 - y0);
  }
}

double Breakpoints::slope(double x) const {
  if (outside(x) || shape_ == Shape::Step) return 0;
  if (shape_ == Shape::Smooth) return smooth_->slope(x);
  const std::size_t i = interval(x);
  const auto [x0, y0] = points_[i];
  const auto [x1, y1] = points_[i + 1];
  if (shape_ == Shape::Exponential) return value(x) * std::log(y1 / y0) / (x1 - x0);
  return (y1 - y0) / (x1 - x0);
}

}  // namespace tactus
