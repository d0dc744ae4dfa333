#include "engine/dsp/curves/breakpoints.h"

#include <algorithm>

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

Breakpoints::Breakpoints(const Points& points, Shape shape)
    : shape_(shape), curve_(shape == Shape::Smooth ? CubicCurve::monotone(points) : CubicCurve{points}) {
  least_ = most_ = points.front().second;
  for (const auto& [x, y] : points) {
    least_ = std::min(least_, y);
    most_ = std::max(most_, y);
  }
}

}  // namespace tactus
