#include "engine/scene/measures/motion.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "engine/core/find_root.h"

namespace tactus {
namespace {

// Samples on each side of a crossing that the curve through it goes by.
constexpr std::size_t kBeside = 4;

/// The polynomial through y[0] ... y[7] at -3 ... 4, by Neville's scheme.
double curve(const double* y, double x) {
  std::array<double, 2 * kBeside> p;
  std::copy_n(y, p.size(), p.begin());
  for (std::size_t order = 1; order < p.size(); ++order)
    for (std::size_t i = 0; i + order < p.size(); ++i) {
      const double at = static_cast<double>(i) - 3.0, width = static_cast<double>(order);
      p[i] = ((at + width - x) * p[i] + (x - at) * p[i + 1]) / width;
    }
  return p[0];
}

// A solver may send back over more than one step what touches for less. [samples]
constexpr double kLongestBounce = 2.0;

/// Where the parabola through three samples in a row, the last of which is the first here, falls through 0.
struct Fall {
  double last = 0.0, before = 0.0, first = 0.0;

  double slope() const { return 0.5 * (3 * last - 4 * before + first); }
  double bend() const { return last - 2 * before + first; }
  double inside() const { return slope() * slope() - 2 * bend() * last; }
  bool reaches() const { return slope() < 0.0 && inside() >= 0.0; }
  /// Samples after the last: the smaller root of  last + slope x + bend x^2 / 2, in the form that does not
  /// cancel.
  double share() const { return 2 * last / (-slope() + std::sqrt(std::max(0.0, inside()))); }
};

/// Where the samples cross `level`, from below to above or the other way, in samples.
struct Crossing {
  double time;
  bool rises;
};
std::vector<Crossing> crossings(std::span<const double> samples, double level) {
  std::vector<Crossing> found;
  for (std::size_t n = kBeside - 1; n + kBeside < samples.size(); ++n) {
    const bool below = samples[n] < level;
    if (below == (samples[n + 1] < level)) continue;
    const auto above = [&](double x) { return curve(&samples[n + 1 - kBeside], x) - level; };
    found.push_back({static_cast<double>(n) + find_zero(above, 0.0, 1.0, 1e-13).near, below});
  }
  return found;
}

/// A moment of each swing: of two rises and the fall between them, which counts twice. An offset of the level
/// moves rises and falls apart, and this not at all; a decay moves it by the third power of its ratio only.
/// Of one swing alone: its rises.
std::vector<double> swings(std::span<const double> samples, double level) {
  const auto all = crossings(samples, level);
  std::vector<double> times, rises;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (!all[i].rises) continue;
    rises.push_back(all[i].time);
    if (i + 2 < all.size()) times.push_back(0.25 * (all[i].time + 2.0 * all[i + 1].time + all[i + 2].time));
  }
  return times.size() > 1 ? times : rises;
}

/// Of the line of least squares; nothing of fewer than two points.
std::optional<double> slope_through(const std::vector<double>& x, std::span<const double> y) {
  if (x.size() < 2) return std::nullopt;
  double mean_x = 0, mean_y = 0, xx = 0, xy = 0;
  const auto count = static_cast<double>(x.size());
  for (std::size_t i = 0; i < x.size(); ++i) mean_x += x[i] / count, mean_y += y[i] / count;
  for (std::size_t i = 0; i < x.size(); ++i) {
    xx += (x[i] - mean_x) * (x[i] - mean_x);
    xy += (x[i] - mean_x) * (y[i] - mean_y);
  }
  return xy / xx;
}

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

std::optional<double> frequency_of(std::span<const double> samples, Hertz rate) {
  if (samples.empty()) return std::nullopt;
  const auto [low, high] = std::ranges::minmax_element(samples);
  const auto times = swings(samples, 0.5 * (*low + *high));
  if (times.size() < 2) return std::nullopt;
  return rate.value * static_cast<double>(times.size() - 1) / (times.back() - times.front());
}

std::optional<double> decay_of(std::span<const double> samples, Hertz rate) {
  std::vector<double> times, logarithms;
  for (std::size_t n = 1; n + 1 < samples.size(); ++n) {
    const double before = std::abs(samples[n - 1]), here = std::abs(samples[n]),
                 after = std::abs(samples[n + 1]);
    if (!(here > before && here >= after) || samples[n - 1] * samples[n + 1] <= 0) continue;
    const double slope = 0.5 * (after - before), bend = after - 2 * here + before;
    times.push_back((static_cast<double>(n) - slope / bend) / rate.value);
    logarithms.push_back(std::log(here - 0.5 * slope * slope / bend));
  }
  const auto slope = slope_through(times, logarithms);
  return slope ? std::optional{-*slope} : std::nullopt;
}

std::optional<double> slope_of(std::span<const double> samples, Hertz rate) {
  std::vector<double> times;
  for (std::size_t n = 0; n < samples.size(); ++n) times.push_back(static_cast<double>(n) / rate.value);
  return slope_through(times, samples);
}

std::vector<double> falls_through_zero(std::span<const double> samples, Hertz rate) {
  std::vector<double> times;
  for (std::size_t n = 1; n < samples.size(); ++n) {
    const double last = samples[n - 1];
    if (!(last > 0.0)) continue;
    const bool follows = n >= 3 && samples[n - 2] > 0.0 && samples[n - 3] > 0.0;
    const Fall fall = follows ? Fall{last, samples[n - 2], samples[n - 3]} : Fall{};
    double share = fall.share();
    if (samples[n] > 0.0) {
      const bool bounced = !times.empty() && times.back() * rate.value > static_cast<double>(n) - 3.0;
      if (bounced || !follows || n + 2 >= samples.size() || !fall.reaches() || !(share > 0.0 && share <= 1.0))
        continue;
      const Fall back{samples[n], samples[n + 1], samples[n + 2]};
      if (!back.reaches() || !(back.share() > 0.0 && back.share() <= kLongestBounce)) continue;
    } else if (!follows || !(share >= 0.0 && share <= 1.5)) {
      share = last / (last - samples[n]);
    }
    times.push_back((static_cast<double>(n - 1) + share) / rate.value);
  }
  return times;
}

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
