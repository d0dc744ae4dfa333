#include "engine/analysis/oscillation.h"

#include <algorithm>
#include <cmath>

#include "engine/physics/find_zero.h"

namespace tactus {
namespace {

/// The cubic through y[0] ... y[3] at -1, 0, 1, 2.
double cubic(const double* y, double x) {
  const double a = (x + 1) * x, b = (x - 1) * (x - 2);
  return -y[0] * x * b / 6 + y[1] * (x + 1) * b / 2 - y[2] * a * (x - 2) / 2 + y[3] * a * (x - 1) / 6;
}

/// Rises through `level`, in samples.
std::vector<double> rises(std::span<const double> samples, double level) {
  std::vector<double> times;
  for (std::size_t n = 1; n + 2 < samples.size(); ++n) {
    if (!(samples[n] < level && samples[n + 1] >= level)) continue;
    const auto above = [&](double x) { return cubic(&samples[n - 1], x) - level; };
    times.push_back(static_cast<double>(n) + find_zero(above, 0.0, 1.0, 1e-12).near);
  }
  return times;
}

struct Line {
  double slope;
  bool known;
};

/// Least squares.
Line line_through(const std::vector<double>& x, const std::vector<double>& y) {
  double mean_x = 0, mean_y = 0, xx = 0, xy = 0;
  const auto count = static_cast<double>(x.size());
  for (std::size_t i = 0; i < x.size(); ++i) mean_x += x[i] / count, mean_y += y[i] / count;
  for (std::size_t i = 0; i < x.size(); ++i) {
    xx += (x[i] - mean_x) * (x[i] - mean_x);
    xy += (x[i] - mean_x) * (y[i] - mean_y);
  }
  return {xy / xx, x.size() > 1};
}

}  // namespace

std::optional<double> frequency_of(std::span<const double> samples, Hertz rate) {
  if (samples.empty()) return std::nullopt;
  const auto [low, high] = std::minmax_element(samples.begin(), samples.end());
  const auto times = rises(samples, 0.5 * (*low + *high));
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
  const auto line = line_through(times, logarithms);
  return line.known ? std::optional{-line.slope} : std::nullopt;
}

std::optional<double> slope_of(std::span<const double> samples, Hertz rate) {
  std::vector<double> times;
  for (std::size_t n = 0; n < samples.size(); ++n) times.push_back(static_cast<double>(n) / rate.value);
  const auto line = line_through(times, {samples.begin(), samples.end()});
  return line.known ? std::optional{line.slope} : std::nullopt;
}

std::vector<double> falls_through_zero(std::span<const double> samples, Hertz rate) {
  std::vector<double> times;
  for (std::size_t n = 1; n < samples.size(); ++n) {
    const double last = samples[n - 1];
    if (!(last > 0.0 && samples[n] <= 0.0)) continue;
    double share = last / (last - samples[n]);
    if (n >= 3 && samples[n - 2] > 0.0 && samples[n - 3] > 0.0) {
      const double slope = 0.5 * (3 * last - 4 * samples[n - 2] + samples[n - 3]);
      const double bend = last - 2 * samples[n - 2] + samples[n - 3];
      // The smaller root of  last + slope x + bend x^2 / 2, in the form that does not cancel.
      const double found = 2 * last / (-slope + std::sqrt(std::max(0.0, slope * slope - 2 * bend * last)));
      if (found >= 0.0 && found <= 1.5) share = found;
    }
    times.push_back((static_cast<double>(n - 1) + share) / rate.value);
  }
  return times;
}

}  // namespace tactus
