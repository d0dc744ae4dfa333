#include "engine/dsp/delays/taps_at_rate.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>

#include "engine/dsp/delays/resample.h"

namespace tactus {
namespace {

constexpr std::size_t kFolded = 32;  // taps that take up what lies before frame 0
constexpr double kBand = 0.5;        // of the lower Nyquist frequency, where they do so best
constexpr double kElsewhere = 1e-4;  // how much an error counts above it
constexpr double kDropped = 1e-8;    // of the sum of all |taps|: what may be left off at the end

/// Solves A x = b in place for a positive definite A, row by row.
void solve(std::vector<double>& a, std::vector<double>& b) {
  const std::size_t n = b.size();
  for (std::size_t pivot = 0; pivot < n; ++pivot)
    for (std::size_t row = pivot + 1; row < n; ++row) {
      const double factor = a[row * n + pivot] / a[pivot * n + pivot];
      for (std::size_t k = pivot; k < n; ++k) a[row * n + k] -= factor * a[pivot * n + k];
      b[row] -= factor * b[pivot];
    }
  for (std::size_t row = n; row-- > 0;) {
    for (std::size_t k = row + 1; k < n; ++k) b[row] -= a[row * n + k] * b[k];
    b[row] /= a[row * n + row];
  }
}

/// Adds to the taps from 0 on what is nearest to `early`, the taps before 0 (the last is at -1):
///   minimum over d of  ∫ W(w) |sum over m >= 0 of d[m] e^(-iwm) - sum over n < 0 of early[n] e^(-iwn)|² dw
/// with W = 1 below `band` [rad/frame] and kElsewhere above it.
void fold(const std::vector<double>& early, double band, std::vector<double>& taps) {
  const auto correlation = [&](std::size_t lag) {
    if (lag == 0) return kElsewhere + (1 - kElsewhere) * band / std::numbers::pi;
    const auto frames = static_cast<double>(lag);
    return (1 - kElsewhere) * std::sin(band * frames) / (std::numbers::pi * frames);
  };
  const auto count = std::min(kFolded, taps.size());
  std::vector<double> matrix, right(count);
  for (std::size_t m = 0; m < count; ++m) {
    for (std::size_t k = 0; k < count; ++k) matrix.push_back(correlation(std::max(m, k) - std::min(m, k)));
    for (std::size_t n = 0; n < early.size(); ++n) right[m] += early[n] * correlation(m + early.size() - n);
  }
  solve(matrix, right);
  for (std::size_t m = 0; m < count; ++m) taps[m] += right[m];
}

void drop_silent_end(std::vector<double>& taps) {
  double sum = 0, tail = 0;
  for (const double tap : taps) sum += std::abs(tap);
  for (; taps.size() > 1; taps.pop_back())
    if ((tail += std::abs(taps.back())) > kDropped * sum) break;
}

/// Frames at `to` that the resampling reaches before and behind.
std::size_t reach_at_rate(Hertz from, Hertz to) {
  return static_cast<std::size_t>(std::ceil(static_cast<double>(resampling_reach(from, to)) * (to / from)));
}

}  // namespace

std::vector<double> taps_at_rate(std::span<const double> taps, Hertz from, Hertz to) {
  if (from == to) return {taps.begin(), taps.end()};
  const auto before = static_cast<std::int64_t>(reach_at_rate(from, to));
  const auto length = static_cast<std::int64_t>(length_at_rate(taps.size(), from, to));
  auto result = resample(taps, from, to, 0, length);
  fold(resample(taps, from, to, -before, before), kBand * std::numbers::pi * std::min(1.0, from / to),
       result);
  for (double& tap : result) tap *= from / to;
  drop_silent_end(result);
  return result;
}

std::size_t length_at_rate(std::size_t taps, Hertz from, Hertz to) {
  if (from == to) return taps;
  const double frames = std::ceil(static_cast<double>(taps) * (to / from));
  return static_cast<std::size_t>(frames) + reach_at_rate(from, to);
}

}  // namespace tactus
