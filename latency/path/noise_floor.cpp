#include "latency/path/noise_floor.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "latency/estimation/fourier.h"

namespace tactus {
namespace {

constexpr std::size_t kWindow = 1024;

std::vector<double> welch(std::span<const double> quiet, double mean) {
  Fourier fourier{kWindow};
  std::vector<double> power(fourier.bins(), 0.0), piece(kWindow);
  double window_power = 0.0;
  int pieces = 0;
  for (std::size_t at = 0; at + kWindow <= quiet.size(); at += kWindow / 2, ++pieces) {
    window_power = 0.0;
    for (std::size_t n = 0; n < kWindow; ++n) {
      const double hann =
          0.5 - 0.5 * std::cos(2 * std::numbers::pi * (static_cast<double>(n) + 0.5) / kWindow);
      piece[n] = hann * (quiet[at + n] - mean);
      window_power += hann * hann;
    }
    const auto spectrum = fourier.forward(piece);
    for (std::size_t b = 0; b < power.size(); ++b) power[b] += std::norm(spectrum[b]);
  }
  for (auto& each : power) each /= window_power * pieces;
  return power;
}

}  // namespace

NoiseFloor NoiseFloor::of(std::span<const double> quiet) {
  NoiseFloor floor;
  floor.per_frame = {0.0, 0.0};
  if (quiet.empty()) return floor;
  const auto frames = static_cast<double>(quiet.size());
  floor.mean = std::accumulate(quiet.begin(), quiet.end(), 0.0) / frames;
  for (const double sample : quiet) floor.variance += (sample - floor.mean) * (sample - floor.mean) / frames;
  if (quiet.size() < 2 * kWindow)
    floor.per_frame = {floor.variance, floor.variance};
  else
    floor.per_frame = welch(quiet, floor.mean);
  return floor;
}

std::vector<double> NoiseFloor::in_bins(std::size_t size, double frames) const {
  std::vector<double> bins(size / 2 + 1);
  const double scale = static_cast<double>(per_frame.size() - 1) / static_cast<double>(bins.size() - 1);
  for (std::size_t b = 0; b < bins.size(); ++b) {
    const double at = static_cast<double>(b) * scale;
    const auto low = std::min(static_cast<std::size_t>(at), per_frame.size() - 2);
    bins[b] = frames * std::lerp(per_frame[low], per_frame[low + 1], at - static_cast<double>(low));
  }
  return bins;
}

}  // namespace tactus
