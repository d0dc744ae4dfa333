#pragma once

#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "engine/dsp/curves/cubic_curve.h"

namespace tactus {

/// A function given by points (x not descending), held at the end values outside them. `Step` holds each
/// value up to the next point, `Exponential` moves by equal factors (values of one sign), `Smooth` is the
/// monotone cubic. Two points at one x are a jump: there the later one counts.
class Breakpoints {
 public:
  enum class Shape { Linear, Step, Exponential, Smooth };
  using Points = std::vector<std::pair<double, double>>;

  /// [control] What keeps `points` from being such a function, in words; nullptr: nothing does.
  static const char* mistake(const Points& points, Shape shape);
  /// [control] `points` has no mistake.
  Breakpoints(Points points, Shape shape);

  /// [realtime]
  double value(double x) const;
  /// [realtime] d value / d x; at a point, that of the interval to its right.
  double slope(double x) const;

  double least() const { return least_; }
  double most() const { return most_; }

 private:
  bool outside(double x) const { return !(x >= points_.front().first && x < points_.back().first); }
  std::size_t interval(double x) const;  ///< number of its left point

  Points points_;
  Shape shape_;
  std::optional<CubicCurve> smooth_;
  double least_, most_;
};

}  // namespace tactus
