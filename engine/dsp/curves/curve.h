#pragma once

#include <utility>
#include <vector>

#include "engine/dsp/curves/curve_kernel.h"

namespace tactus {

/// A smooth curve through points (x ascending): a cubic in each interval, given by the values and slopes at
/// its ends, so that value and slope are continuous. Outside the points it is level, at the end values.
class CubicCurve {
 public:
  using Points = std::vector<std::pair<double, double>>;

  /// [control] No overshoot: between two points the curve stays between their values; level at both ends.
  /// Fritsch & Butland, "A method for constructing local monotone piecewise cubic interpolants", SIAM 1984.
  static CubicCurve monotone(const Points& points);
  /// [control] Second derivative continuous as well; level at both ends (clamped spline). It may overshoot.
  /// de Boor, "A practical guide to splines", 1978, chapter IV.
  static CubicCurve spline(const Points& points);

  /// [control] All slopes are 0.
  explicit CubicCurve(const Points& points);

  /// [realtime] Valid as long as this object.
  tactus_curve view() const { return {static_cast<int>(x_.size()), x_.data(), value_.data(), slope_.data()}; }

 private:
  std::vector<double> x_, value_, slope_;
};

/// A function given by points (x not descending), held at the end values outside them; its cubic is the
/// monotone one. Two points at one x are a jump: there the later one counts.
class Breakpoints {
 public:
  using Shape = tactus_curve_shape;
  using Points = CubicCurve::Points;

  /// [control] Why `points` are no such function, as part of a message; nullptr: they are one.
  static const char* error_in(const Points& points, Shape shape);
  /// [control] `points` without error.
  Breakpoints(const Points& points, Shape shape)
      : shape_(shape),
        curve_(shape == TACTUS_CURVE_CUBIC ? CubicCurve::monotone(points) : CubicCurve{points}) {}

  /// [realtime]
  double value(double x) const {
    const auto curve = curve_.view();
    return tactus_curve_value(&curve, shape_, x);
  }
  /// [realtime] Valid as long as this object.
  tactus_curve view() const { return curve_.view(); }
  /// [realtime] d value / d x; at a point, that of the interval to its right.
  double slope(double x) const {
    const auto curve = curve_.view();
    return tactus_curve_slope(&curve, shape_, x);
  }

 private:
  Shape shape_;
  CubicCurve curve_;
};

}  // namespace tactus
