#pragma once

#include <utility>
#include <vector>

#include "engine/dsp/curves/cubic_curve.h"

namespace tactus {

/// A function given by points (x not descending), held at the end values outside them. `Step` holds each
/// value up to the next point, `Exponential` moves by equal factors (values of one sign), `Smooth` is the
/// monotone cubic. Two points at one x are a jump: there the later one counts.
class Breakpoints {
 public:
  enum class Shape {
    Linear = TACTUS_CURVE_LINEAR,
    Step = TACTUS_CURVE_STEP,
    Exponential = TACTUS_CURVE_EXPONENTIAL,
    Smooth = TACTUS_CURVE_CUBIC
  };
  using Points = std::vector<std::pair<double, double>>;

  /// [control] What keeps `points` from being such a function, in words; nullptr: nothing does.
  static const char* mistake(const Points& points, Shape shape);
  /// [control] `points` has no mistake.
  Breakpoints(const Points& points, Shape shape);

  /// [realtime]
  double value(double x) const {
    const auto curve = curve_.view();
    return tactus_curve_value(&curve, static_cast<tactus_curve_shape>(shape_), x);
  }
  /// [realtime] d value / d x; at a point, that of the interval to its right.
  double slope(double x) const {
    const auto curve = curve_.view();
    return tactus_curve_slope(&curve, static_cast<tactus_curve_shape>(shape_), x);
  }

  double least() const { return least_; }
  double most() const { return most_; }

 private:
  Shape shape_;
  CubicCurve curve_;
  double least_, most_;
};

}  // namespace tactus
