#include "latency/path/delay_error.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstddef>

namespace tactus {
namespace {

constexpr double kBand = 1.19;           // a quarter of an octave
constexpr double kWholeBursts = 0.6;     // of their variance, which so few do not determine better
constexpr std::size_t kShapeBands = 16;  // equally wide
constexpr double kShapeCertain = 3.0;    // standard deviations
// Frames of delay for a log gain that falls by 1 towards high frequencies: a second path one to two frames
// behind the first makes the one of the other.
constexpr double kByDroop = 0.1;

std::vector<std::size_t> octave_edges(std::size_t low, std::size_t end) {
  std::vector<std::size_t> edges{low};
  while (edges.back() < end)
    edges.push_back(std::min(
        end,
        std::max(edges.back() + 1, static_cast<std::size_t>(kBand * static_cast<double>(edges.back())))));
  return edges;
}

using Rows = std::vector<std::vector<double>>;  ///< of each burst, its bands

/// The variance of the weighted mean of one column, from the scatter around it.
template <class Value>
double variance_of_mean(const std::vector<RepeatedWindow>& bursts, const Value& value) {
  double mean = 0.0, variance = 0.0;
  for (std::size_t i = 0; i < bursts.size(); ++i) mean += bursts[i].weight * value(i);
  for (std::size_t i = 0; i < bursts.size(); ++i) {
    const double weight = bursts[i].weight, off = value(i) - mean;
    variance += weight * weight * off * off / (1.0 - weight);
  }
  return variance;
}

double noise_of(const CapturedWindow& mean, const PathFit& fit, const std::vector<RepeatedWindow>& bursts) {
  const auto edges = octave_edges(mean.lowest_bin, mean.captured.size() - 1);
  Rows rows;
  for (const auto& burst : bursts) rows.push_back(delay_influences(mean, burst.captured, fit, edges));
  double by_bands = 0.0;
  for (std::size_t k = 0; k + 1 < edges.size(); ++k)
    by_bands += variance_of_mean(bursts, [&](std::size_t i) { return rows[i][k]; });
  std::vector<double> sums;
  for (const auto& row : rows) {
    double sum = 0.0;
    for (const double each : row) sum += each;
    sums.push_back(sum);
  }
  const double by_bursts = variance_of_mean(bursts, [&](std::size_t i) { return sums[i]; });
  return std::sqrt(std::max(by_bands, kWholeBursts * by_bursts));
}

/// The mean phase of what the model leaves, in equal bands.
std::vector<double> phases(const CapturedWindow& window, const Spectrum& captured, const Spectrum& answer,
                           const std::vector<double>& weights) {
  std::vector<double> sums(weights.size(), 0.0);
  const auto low = window.lowest_bin, count = captured.size() - 1 - low;
  for (auto b = low; b < low + count; ++b)
    sums[(b - low) * weights.size() / count] +=
        2.0 / window.noise[b] * (std::conj(answer[b]) * (captured[b] - answer[b])).imag();
  for (std::size_t k = 0; k < sums.size(); ++k) sums[k] /= std::max(weights[k], 1e-300);
  return sums;
}

double shape_of(const CapturedWindow& mean, const PathFit& fit, const std::vector<RepeatedWindow>& bursts) {
  auto answer = fit.model.spectrum(mean.size, mean.profile);
  std::vector<double> weights(kShapeBands, 0.0);
  double slopes = 0.0;
  const auto low = mean.lowest_bin, count = mean.captured.size() - 1 - low;
  for (auto b = low; b < low + count; ++b) {
    answer[b] *= mean.played[b];
    const double weight = 2.0 / mean.noise[b] * std::norm(answer[b]);
    const double w = angular_frequency(b, mean.size);
    weights[(b - low) * kShapeBands / count] += weight;
    slopes += weight * w * w;
  }
  const auto left = phases(mean, mean.captured, answer, weights);
  Rows rows;
  for (const auto& burst : bursts) rows.push_back(phases(mean, burst.captured, answer, weights));
  double found = 0.0, noise = 0.0, squares = 0.0;
  for (std::size_t k = 0; k < kShapeBands; ++k) {
    const double variance = weights[k] * variance_of_mean(bursts, [&](std::size_t i) { return rows[i][k]; });
    found += weights[k] * left[k] * left[k];
    noise += variance;
    squares += variance * variance;
  }
  const double beyond = found - noise - kShapeCertain * std::sqrt(2.0 * squares);
  return std::sqrt(std::max(0.0, beyond) / slopes);
}

}  // namespace

DelayError DelayError::of(const CapturedWindow& mean, const PathFit& fit,
                          const std::vector<RepeatedWindow>& bursts) {
  return {noise_of(mean, fit, bursts), std::hypot(shape_of(mean, fit, bursts), kByDroop * fit.droop)};
}

}  // namespace tactus
