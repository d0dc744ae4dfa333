#pragma once

// Thread: [any].

#include <algorithm>
#include <cmath>
#include <limits>

namespace tactus {

inline constexpr double kUnlimited = std::numeric_limits<double>::infinity();

/// All values that a signal can take: what bounds the delays, and so the sub-blocks, of a graph.
struct Interval {
  double low = -kUnlimited;
  double high = kUnlimited;

  static Interval exactly(double value) { return {value, value}; }
  bool bounded() const { return std::isfinite(low) && std::isfinite(high); }
  bool single() const { return low == high; }
  bool contains(double value) const { return low <= value && value <= high; }
  Interval joined(Interval other) const { return {std::min(low, other.low), std::max(high, other.high)}; }
};

inline Interval operator+(Interval a, Interval b) { return {a.low + b.low, a.high + b.high}; }
inline Interval operator-(Interval a, Interval b) { return {a.low - b.high, a.high - b.low}; }
inline Interval operator-(Interval a) { return {-a.high, -a.low}; }
inline Interval operator*(Interval a, Interval b) {
  // 0 * infinity counts as 0: an end of a range represents values close to it.
  const auto product = [](double x, double y) { return x == 0 || y == 0 ? 0 : x * y; };
  const auto [low, high] = std::minmax(
      {product(a.low, b.low), product(a.low, b.high), product(a.high, b.low), product(a.high, b.high)});
  return {low, high};
}
/// Unbounded when `b` contains 0.
inline Interval divide(Interval a, Interval b) {
  if (b.contains(0)) return {};
  return a * Interval{std::min(1 / b.low, 1 / b.high), std::max(1 / b.low, 1 / b.high)};
}
inline Interval min(Interval a, Interval b) { return {std::min(a.low, b.low), std::min(a.high, b.high)}; }
inline Interval max(Interval a, Interval b) { return {std::max(a.low, b.low), std::max(a.high, b.high)}; }
inline Interval abs(Interval a) {
  return a.low >= 0 ? a : a.high <= 0 ? -a : Interval{0, std::max(-a.low, a.high)};
}

}  // namespace tactus
