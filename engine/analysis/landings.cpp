#include "engine/analysis/landings.h"

namespace tactus {
namespace {

/// Slope at the last of three samples; of second order.
double slope_after(std::span<const double> x, std::size_t n, Hertz rate) {
  return 0.5 * (3 * x[n] - 4 * x[n - 1] + x[n - 2]) * rate.value;
}
/// Slope at the first of three samples.
double slope_before(std::span<const double> x, std::size_t n, Hertz rate) {
  return -0.5 * (3 * x[n] - 4 * x[n + 1] + x[n + 2]) * rate.value;
}
double bend(std::span<const double> x, std::size_t n, Hertz rate) {
  return (x[n] - 2 * x[n - 1] + x[n - 2]) * rate.value * rate.value;
}

}  // namespace

std::vector<Landing> landings_of(std::span<const double> ball, std::span<const double> table, Hertz rate) {
  std::vector<Landing> found;
  const auto gap = [&](std::size_t n) { return ball[n] - table[n]; };
  for (std::size_t n = 3; n + 2 < ball.size(); ++n) {
    if (gap(n) > 0 || gap(n - 1) <= 0 || gap(n - 2) <= 0 || gap(n - 3) <= 0) continue;
    std::size_t off = n;
    while (off + 2 < ball.size() && gap(off) <= 0) ++off;
    if (off + 2 >= ball.size()) break;
    const std::size_t last = n - 1;
    const double table_speed = slope_after(table, last, rate);
    const double touching_s = static_cast<double>(off - last) / rate.value;
    found.push_back({(static_cast<double>(last) + gap(last) / (gap(last) - gap(n))) / rate.value,
                     table_speed - slope_after(ball, last, rate),
                     slope_before(ball, off, rate) - bend(ball, last, rate) * touching_s - table_speed});
    n = off;
  }
  return found;
}

}  // namespace tactus
