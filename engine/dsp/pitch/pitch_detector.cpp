#include "engine/dsp/pitch/pitch_detector.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <numeric>
#include <optional>

#include "engine/core/decibels.h"
#include "engine/core/units.h"

namespace tactus {
namespace {

constexpr double kLeastClarity = 0.8, kNearHighest = 0.9;
constexpr double kSilence = 1e-6, kFarBelow = 1e-3;
constexpr int kPartials = 12;

/// Means of `by` samples each: enough for the coarse search, and so much less to multiply.
std::vector<double> thinned(std::span<const double> x, std::size_t by) {
  std::vector<double> means(x.size() / by);
  for (std::size_t i = 0; i < means.size(); ++i) {
    const auto some = x.subspan(i * by, by);
    means[i] = std::accumulate(some.begin(), some.end(), 0.0) / static_cast<double>(by);
  }
  return means;
}

std::vector<double> without_mean(std::span<const double> x) {
  const double sum = std::accumulate(x.begin(), x.end(), 0.0);
  std::vector<double> rest(x.begin(), x.end());
  for (double& v : rest) v -= sum / static_cast<double>(x.size());
  return rest;
}

/// Offset of the top of the parabola through three equally distant values, in [-0.5, 0.5].
double top(double before, double at, double after) {
  const double curvature = before - 2 * at + after;
  return curvature < 0 ? std::clamp(0.5 * (before - after) / curvature, -0.5, 0.5) : 0;
}

struct Period {
  double frames, clarity;
};

/// n(t) of the coarse search, for t up to the longest period and one beyond.
std::vector<double> likeness(std::span<const double> x, std::size_t window, std::size_t longest) {
  std::vector<double> n(longest + 2, 0.0);
  for (std::size_t t = 0; t < n.size(); ++t) {
    double product = 0, power = 0;
    for (std::size_t j = 0; j < window; ++j) {
      product += x[j] * x[j + t];
      power += x[j] * x[j] + x[j + t] * x[j + t];
    }
    n[t] = power > 0 ? 2 * product / power : 0;
  }
  return n;
}

std::optional<Period> coarse_period(const std::vector<double>& n, std::size_t shortest) {
  std::vector<std::size_t> peaks;
  double highest = 0;
  std::size_t t = 1;
  while (t + 1 < n.size() && n[t] > 0) ++t;  // away from t = 0, where all is like itself
  for (t = std::max(t, shortest); t + 1 < n.size(); ++t) {
    if (n[t] < kLeastClarity || n[t] < n[t - 1] || n[t] <= n[t + 1]) continue;
    peaks.push_back(t);
    highest = std::max(highest, n[t]);
  }
  for (const auto peak : peaks) {
    if (n[peak] < kNearHighest * highest) continue;
    return Period{static_cast<double>(peak) + top(n[peak - 1], n[peak], n[peak + 1]), std::min(1.0, n[peak])};
  }
  return std::nullopt;
}

using Partials = std::array<std::complex<double>, kPartials>;

/// Through a Hann window of four periods from `start` on; turning as if it began at sample 0.
Partials partials(std::span<const double> x, double start, double period) {
  Partials sums{};
  const auto first = static_cast<std::size_t>(start);
  const double length = 4 * period;
  for (std::size_t n = first; static_cast<double>(n - first) < length; ++n) {
    const double at = static_cast<double>(n - first);
    const double weight = x[n] * (1 - std::cos(2 * kPi * at / length));
    const auto turn = std::polar(1.0, -2 * kPi * static_cast<double>(n) / period);
    auto turned = turn;
    for (auto& sum : sums) {
      sum += weight * turned;
      turned *= turn;
    }
  }
  return sums;
}

struct Fine {
  double period;
  int partial;
};

/// One step: windows two periods apart around `middle`.
Fine refined(std::span<const double> x, double middle, double period) {
  const double start = std::floor(middle - 3 * period);
  const double apart = std::floor(2 * period);
  const auto early = partials(x, start, period), late = partials(x, start + apart, period);
  double turned = 0, weights = 0, strongest = 0;
  int partial = 1;
  for (int h = 1; h <= kPartials; ++h) {
    const auto k = static_cast<std::size_t>(h - 1);
    if (2 * h > period) break;  // above half the rate
    const double power = std::abs(early[k] * late[k]);
    turned += power * h * std::arg(late[k] * std::conj(early[k]));
    weights += power * h * h;
    if (power > strongest) strongest = power, partial = h;
  }
  if (weights <= 0) return {period, 1};
  const double turns = 1 / period + turned / weights / (2 * kPi * apart);
  return {1 / turns, partial};
}

class Tracker {
 public:
  Tracker(std::span<const double> samples, Hertz rate, Hertz lo, Hertz hi)
      : samples_(samples),
        rate_(rate.value),
        longest_(rate.value / lo.value),
        by_(static_cast<std::size_t>(std::max(1.0, std::floor(rate.value / (12 * hi.value))))),
        thin_(thinned(samples, by_)),
        thin_longest_(static_cast<std::size_t>(std::ceil(longest_ / static_cast<double>(by_)))),
        thin_shortest_(static_cast<std::size_t>(rate.value / hi.value / static_cast<double>(by_))) {}

  std::vector<PitchPoint> run() const {
    std::vector<PitchPoint> points;
    const double end = static_cast<double>(samples_.size()) / rate_;
    for (int i = 0; i * kPitchHop_s < end; ++i)
      if (const auto point = at(i * kPitchHop_s)) points.push_back(*point);
    double loudest = 0;
    for (const auto& point : points) loudest = std::max(loudest, point.rms);
    std::erase_if(points, [&](const auto& point) { return point.rms < kFarBelow * loudest; });
    return points;
  }

 private:
  std::optional<PitchPoint> at(double time_s) const {
    const auto window = 2 * thin_longest_;
    const auto reach = window + thin_longest_ + 2;
    const double middle = time_s * rate_;
    const double thin_middle = middle / static_cast<double>(by_);
    const double first = thin_middle - 0.5 * static_cast<double>(reach);
    // At the ends of the recording the window stays inside.
    if (thin_.size() < reach) return std::nullopt;
    const auto start =
        static_cast<std::size_t>(std::clamp(first, 0.0, static_cast<double>(thin_.size() - reach)));
    const auto section = without_mean(std::span{thin_}.subspan(start, reach));
    if (rms_of(section) < kSilence) return std::nullopt;
    auto coarse = coarse_period(likeness(section, window, thin_longest_), thin_shortest_);
    if (!coarse) return std::nullopt;
    return fine(time_s, middle, coarse->frames * static_cast<double>(by_), coarse->clarity);
  }

  std::optional<PitchPoint> fine(double time_s, double middle, double period, double clarity) const {
    Fine found{period, 1};
    for (int step = 0; step < 2; ++step) {
      if (middle < 3.2 * found.period ||
          middle + 3.2 * found.period + 2 > static_cast<double>(samples_.size()))
        return std::nullopt;
      found = refined(samples_, middle, found.period);
      // It ran away: no pitch after all.
      if (!(std::abs(found.period / period - 1) < 0.06)) return std::nullopt;
    }
    const auto from = static_cast<std::size_t>(middle - 3 * found.period);
    const auto length = static_cast<std::size_t>(6 * found.period);
    return PitchPoint{time_s, rate_ / found.period, clarity, found.partial,
                      rms_of(samples_.subspan(from, length))};
  }

  std::span<const double> samples_;
  double rate_, longest_;
  std::size_t by_;
  std::vector<double> thin_;
  std::size_t thin_longest_, thin_shortest_;
};

}  // namespace

std::vector<PitchPoint> track_pitch(std::span<const double> samples, Hertz rate, Hertz lo, Hertz hi) {
  return Tracker{samples, rate, lo, hi}.run();
}

}  // namespace tactus
