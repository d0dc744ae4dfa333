#include "latency/estimation/delay_trend.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "engine/core/index.h"
#include "engine/core/median.h"
#include "engine/dsp/delays/resample.h"

namespace tactus {
namespace {

double slope_between(const DelayPoint& a, const DelayPoint& b) {
  return (b.delay_frames - a.delay_frames) / static_cast<double>(b.played_at - a.played_at);
}

double neighbours_slope(std::span<const DelayPoint> points) {
  std::vector<double> slopes;
  for (std::size_t n = 1; n < points.size(); ++n) slopes.push_back(slope_between(points[n - 1], points[n]));
  return median(slopes);
}

/// The points between two steps, and their means.
struct Segment {
  std::vector<std::size_t> points;
  double time = 0.0, delay = 0.0;
};

std::vector<Segment> segments(std::span<const DelayPoint> points, double slope, double least_step,
                              std::vector<DelayStep>& steps) {
  std::vector<Segment> found{{{0}}};
  const auto level = [&](std::size_t n) {
    return points[n].delay_frames - slope * static_cast<double>(points[n].played_at);
  };
  std::vector<double> levels{level(0)};  // since the last step
  for (std::size_t n = 1; n < points.size(); ++n) {
    const double jump = level(n) - median(levels);
    if (std::abs(jump) > least_step) {
      steps.push_back({points[n].played_at, jump});
      found.emplace_back();
      levels.clear();
    }
    levels.push_back(level(n));
    found.back().points.push_back(n);
  }
  for (auto& part : found)
    for (const auto n : part.points) {
      part.time += static_cast<double>(points[n].played_at) / static_cast<double>(part.points.size());
      part.delay += points[n].delay_frames / static_cast<double>(part.points.size());
    }
  return found;
}

}  // namespace

DelayTrend DelayTrend::of(std::span<const DelayPoint> points, double least_step) {
  DelayTrend trend;
  if (points.empty()) return trend;
  const auto parts = segments(points, neighbours_slope(points), least_step, trend.steps);
  double times = 0.0, common = 0.0;
  for (const auto& part : parts)
    for (const auto n : part.points) {
      const double time = static_cast<double>(points[n].played_at) - part.time;
      times += time * time;
      common += time * (points[n].delay_frames - part.delay);
    }
  if (times > 0.0) trend.slope = common / times;

  double squares = 0.0;
  for (const auto& part : parts) {
    double of_part = 0.0;
    for (const auto n : part.points) {
      const double off = points[n].delay_frames - part.delay -
                         trend.slope * (static_cast<double>(points[n].played_at) - part.time);
      of_part += off * off;
    }
    squares += of_part;
    const auto count = part.points.size();
    if (count <= trend.longest.size()) continue;
    trend.longest = part.points;
    if (count > 1) trend.scatter = std::sqrt(of_part / static_cast<double>(count - 1));
  }
  const auto left = static_cast<double>(points.size()) - static_cast<double>(parts.size()) - 1.0;
  if (left > 0.0 && times > 0.0) trend.slope_deviation = std::sqrt(squares / left / times);
  return trend;
}

std::vector<double> at_speed(std::span<const double> samples, double speed) {
  constexpr int kHalf = 32;
  constexpr int kSteps = 512;  // of the table, for each frame
  constexpr double kBeta = 9.0;
  const auto kernel = [](double x) {
    if (std::abs(x) >= kHalf) return 0.0;
    const double window = bessel_i0(kBeta * std::sqrt(1.0 - (x / kHalf) * (x / kHalf))) / bessel_i0(kBeta);
    return window * (x == 0.0 ? 1.0 : std::sin(std::numbers::pi * x) / (std::numbers::pi * x));
  };
  // Row r holds the weights of the 64 samples around a place r / kSteps behind the 32nd of them.
  std::vector<double> table;
  for (int r = 0; r <= kSteps; ++r)
    for (int k = 0; k < 2 * kHalf; ++k)
      table.push_back(kernel(k - (kHalf - 1) - static_cast<double>(r) / kSteps));

  std::vector<double> out(samples.size());
  const auto size = static_cast<std::int64_t>(samples.size());
  for (std::size_t n = 0; n < out.size(); ++n) {
    const double at = static_cast<double>(n) * speed;
    const double whole = std::floor(at);
    const double row = (at - whole) * kSteps;
    const auto first = static_cast<std::int64_t>(whole) - (kHalf - 1);
    const auto* low = table.data() + static_cast<std::size_t>(row) * 2 * kHalf;
    const auto* high = low + 2 * kHalf;
    const double share = row - std::floor(row);
    const auto from = std::max<std::int64_t>(0, -first), to = std::min<std::int64_t>(2 * kHalf, size - first);
    double sum = 0.0;
    for (auto k = from; k < to; ++k) sum += std::lerp(low[k], high[k], share) * samples[index(first + k)];
    out[n] = sum;
  }
  return out;
}

}  // namespace tactus
