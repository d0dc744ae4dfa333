#pragma once

// Thread: [any].

#include <algorithm>
#include <cmath>
#include <limits>

namespace tactus {

/// All values that a signal can take: what bounds the delays, and so the sub-blocks, of a graph.
struct Interval {
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();

  static Interval exactly(double value) { return {value, value}; }
  bool bounded() const { return std::isfinite(low) && std::isfinite(high); }
  bool single() const { return low == high; }
  bool contains(double value) const { return low <= value && value <= high; }
  Interval joined(Interval other) const { return {std::min(low, other.low), std::max(high, other.high)}; }
};

Interval operator+(Interval a, Interval b);
Interval operator-(Interval a, Interval b);
Interval operator*(Interval a, Interval b);
/// Unbounded when `b` contains 0.
Interval operator/(Interval a, Interval b);
Interval operator-(Interval a);
Interval min(Interval a, Interval b);
Interval max(Interval a, Interval b);
Interval abs(Interval a);

}  // namespace tactus
