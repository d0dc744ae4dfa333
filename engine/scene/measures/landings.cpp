#include "engine/scene/measures/landings.h"

#include <algorithm>
#include <cmath>
#include <numeric>

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
double mean_of(const std::vector<double>& values) {
  return values.empty()
             ? 0
             : std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}
double curvature(std::span<const double> x, std::size_t n, Hertz rate) {
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
                     slope_before(ball, off, rate) - curvature(ball, last, rate) * touching_s - table_speed});
    n = off;
  }
  return found;
}

double split_of(const std::vector<double>& speeds, int apart) {
  const auto step = static_cast<std::size_t>(apart);
  if (speeds.size() <= step) return 0;
  double sum = 0;
  for (std::size_t i = step; i < speeds.size(); ++i) sum += std::pow(speeds[i] - speeds[i - step], 2);
  return std::sqrt(sum / static_cast<double>(speeds.size() - step));
}

int period_of(const std::vector<double>& speeds) {
  for (int period = 1; period <= kLongestOrbit; ++period)
    if (speeds.size() > 2 * static_cast<std::size_t>(period) &&
        split_of(speeds, period) <= kAlikeLandings * mean_of(speeds))
      return period;
  return 0;
}

Bouncing bouncing_in(std::span<const double> ball, std::span<const double> table, Hertz rate, double from_s,
                     double to_s) {
  Bouncing found;
  std::vector<double> times;
  for (const auto& landing : landings_of(ball, table, rate)) {
    if (landing.time_s < from_s || landing.time_s >= to_s) continue;
    times.push_back(landing.time_s);
    found.speeds.push_back(landing.speed);
  }
  found.period = period_of(found.speeds);
  if (times.size() < 2) return found;
  // Over whole orbits, whose landings need not be equally far apart.
  const auto orbit = static_cast<std::size_t>(std::max(1, found.period));
  const auto last = (times.size() - 1) / orbit * orbit;
  found.landings_per_second = static_cast<double>(last) / (times[last] - times.front());
  return found;
}

}  // namespace tactus
