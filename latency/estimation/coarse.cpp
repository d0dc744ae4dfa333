#include "latency/estimation/coarse.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <numeric>
#include <utility>

#include "engine/core/index.h"
#include "engine/core/median.h"

namespace tactus {
namespace {

constexpr double kLeastShare = 0.125;  // of the probe's energy must lie within the recording
constexpr Seconds kEdge{0.01};
constexpr std::size_t kAround = 96;       // frames: by 400 ppm two clocks differ by so much in five seconds
constexpr double kCoarseRounding = 1e-9;  // of the mean: DC only
constexpr double kLowest = 60.0;          // Hz; below there is hum, and little that defines a delay

std::size_t loudest(const std::vector<double>& values, std::size_t from, std::size_t to) {
  const auto begin = values.begin() + static_cast<std::ptrdiff_t>(from),
             end = values.begin() + static_cast<std::ptrdiff_t>(to);
  return static_cast<std::size_t>(
      std::max_element(begin, end, [](double a, double b) { return std::abs(a) < std::abs(b); }) -
      values.begin());
}

/// The highest value where there is most power around. When the clocks differ, every probe has a delay of its
/// own, and together they are no higher than one of them that meets its neighbour.
std::size_t densest(const std::vector<double>& values) {
  double sum = 0.0, highest = 0.0;
  std::size_t end = 0;
  for (std::size_t n = 0; n < values.size(); ++n) {
    sum += values[n] * values[n];
    if (n >= kAround) sum -= values[n - kAround] * values[n - kAround];
    if (sum <= highest) continue;
    highest = sum;
    end = n + 1;
  }
  return loudest(values, end > kAround ? end - kAround : 0, end);
}

}  // namespace

CoarseSearch::CoarseSearch(std::span<const double> played, std::size_t frames, Hertz sample_rate)
    : sample_rate_(sample_rate),
      frames_(static_cast<std::int64_t>(frames)),
      fourier_(frames + played.size()),
      played_(fourier_.forward(played)),
      played_power_(smoothed_power(played_)),
      energy_(played.size() + 1, 0.0) {
  for (std::size_t n = 0; n < played.size(); ++n) energy_[n + 1] = energy_[n] + played[n] * played[n];
}

double CoarseSearch::share_within(std::int64_t delay) const {
  const auto length = static_cast<std::int64_t>(energy_.size()) - 1;
  const auto from = std::clamp<std::int64_t>(-delay, 0, length),
             to = std::clamp<std::int64_t>(frames_ - delay, from, length);
  return (energy_[index(to)] - energy_[index(from)]) / energy_.back();
}

std::vector<double> CoarseSearch::correlation(std::span<const double> captured) {
  // Its mean, and its edges, would be captured everywhere.
  const double mean =
      std::accumulate(captured.begin(), captured.end(), 0.0) / static_cast<double>(captured.size());
  std::vector<double> centred(captured.begin(), captured.end());
  double farthest = 0.0;
  for (const double sample : captured) farthest = std::max(farthest, std::abs(sample - mean));
  if (farthest <= kCoarseRounding * std::abs(mean)) return std::vector<double>(fourier_.size(), 0.0);
  const auto edge = std::min(captured.size() / 2, static_cast<std::size_t>(frames_in(kEdge, sample_rate_)));
  for (std::size_t n = 0; n < centred.size(); ++n) {
    const double inside =
        static_cast<double>(std::min({n, centred.size() - 1 - n, edge})) / static_cast<double>(edge + 1);
    centred[n] = (centred[n] - mean) * (0.5 - 0.5 * std::cos(std::numbers::pi * inside));
  }
  auto cross = fourier_.forward(centred);
  const auto power = smoothed_power(cross);
  const double gain = std::accumulate(power.begin(), power.end(), 0.0) /
                      std::accumulate(played_power_.begin(), played_power_.end(), 0.0);
  const auto lowest =
      static_cast<std::size_t>(kLowest / sample_rate_.value * static_cast<double>(fourier_.size()));
  for (std::size_t b = 0; b < cross.size(); ++b)
    cross[b] =
        b < lowest ? 0.0 : cross[b] * std::conj(played_[b]) / (power[b] + gain * played_power_[b] + 1e-300);
  return fourier_.inverse(cross);
}

CoarseDelay CoarseSearch::find(std::span<const double> captured) {
  const auto correlated = correlation(captured);
  const auto size = static_cast<std::int64_t>(correlated.size());
  std::vector<double> values, evened;
  std::vector<std::int64_t> delays;
  for (std::int64_t delay = frames_ - size; delay < frames_; ++delay) {
    const double share = share_within(delay);
    if (share < kLeastShare) continue;
    values.push_back(correlated[index((delay + size) % size)]);
    evened.push_back(values.back() / std::sqrt(share));  // noise correlates with what there is of the probe
    delays.push_back(delay);
  }
  CoarseDelay found;
  const double deviation = robust_deviation(evened);
  if (!(deviation > 0.0)) return found;
  auto best = loudest(evened, 0, evened.size());
  if (std::abs(evened[best]) > CoarseDelay::kClear * deviation) best = densest(values);
  found.prominence = std::abs(evened[best]) / deviation;
  found.sign = evened[best] < 0.0 ? -1.0 : 1.0;
  found.frames = delays[best];
  return found;
}

std::vector<double> CoarseSearch::from(Hertz lowest, Spectrum spectrum) {
  const double bins = lowest / sample_rate_ * static_cast<double>(fourier_.size());
  std::fill_n(spectrum.begin(), static_cast<std::size_t>(std::ceil(bins)), 0.0);
  auto samples = fourier_.inverse(spectrum);
  samples.resize(index(frames_));
  return samples;
}

std::vector<double> CoarseSearch::behind(const PathModel& model, Hertz lowest) {
  auto spectrum = model.spectrum(fourier_.size(), {});
  for (std::size_t b = 0; b < spectrum.size(); ++b) spectrum[b] *= played_[b];
  return from(lowest, std::move(spectrum));
}

std::vector<double> CoarseSearch::above(std::span<const double> captured, Hertz lowest) {
  return from(lowest, fourier_.forward(captured));
}

}  // namespace tactus
