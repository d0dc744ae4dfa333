#pragma once

#include <utility>
#include <vector>

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

  /// [realtime] Value, slope and second derivative at x.
  double value(double x) const;
  double slope(double x) const;
  double curvature(double x) const;

 private:
  struct Interval {
    double width, at;  ///< `at` in [0, 1]
    double left, right, left_slope, right_slope;
  };
  explicit CubicCurve(const Points& points);
  bool outside(double x) const { return !(x > x_.front() && x < x_.back()); }
  Interval interval(double x) const;

  std::vector<double> x_, value_, slope_;
};

}  // namespace tactus
