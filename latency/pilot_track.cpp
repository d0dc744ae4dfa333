#include "latency/pilot_track.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "latency/fourier.h"
#include "latency/median.h"

namespace tactus {
namespace {

constexpr std::int64_t kPiece = 2048;
constexpr std::int64_t kReach = 4096;
constexpr std::int64_t kLead = 64;  // what a filter may answer before its delay
constexpr double kProminent = 10.0;

/// What the path would bring, from `kLead` frames before its delay on.
std::vector<double> expected(std::span<const double> pilot, const PathModel& model,
                             std::span<const double> profile) {
  Fourier fourier{pilot.size() + profile.size() + 2 * kLead};
  auto placed = model;
  placed.delay_frames += static_cast<double>(kLead);
  const auto path = placed.spectrum(fourier.size(), profile.empty() ? Spectrum{} : fourier.forward(profile));
  auto spectrum = fourier.forward(pilot);
  for (std::size_t b = 0; b < spectrum.size(); ++b) spectrum[b] *= path[b];
  auto signal = fourier.inverse(spectrum);
  signal.resize(pilot.size() + 2 * kLead);
  return signal;
}

std::vector<double> cut(std::span<const double> all, std::int64_t from, std::int64_t frames) {
  std::vector<double> piece(static_cast<std::size_t>(frames), 0.0);
  const auto end = std::min(from + frames, static_cast<std::int64_t>(all.size()));
  for (auto n = std::max<std::int64_t>(0, from); n < end; ++n)
    piece[static_cast<std::size_t>(n - from)] = all[static_cast<std::size_t>(n)];
  return piece;
}

}  // namespace

std::vector<DelayPoint> track_pilot(std::span<const double> played, std::span<const double> heard,
                                    const Burst& pilot, std::int64_t at, const PathModel& model,
                                    std::span<const double> profile) {
  const auto whole =
      expected(played.subspan(static_cast<std::size_t>(pilot.at), static_cast<std::size_t>(pilot.frames)),
               model, profile);
  Fourier fourier{static_cast<std::size_t>(kPiece + 2 * kReach)};
  std::vector<DelayPoint> points;
  for (std::int64_t from = 0; from + kPiece <= pilot.frames; from += kPiece / 2) {
    const auto piece = fourier.forward(cut(whole, from, kPiece));
    auto cross = fourier.forward(cut(heard, pilot.at + at + from - kLead - kReach, kPiece + 2 * kReach));
    for (std::size_t b = 0; b < cross.size(); ++b) cross[b] *= std::conj(piece[b]);
    auto correlation = fourier.inverse(cross);
    correlation.resize(static_cast<std::size_t>(2 * kReach));
    const auto highest = std::max_element(correlation.begin(), correlation.end());
    if (!(*highest > kProminent * robust_deviation(correlation))) continue;
    const auto off = highest - correlation.begin() - kReach;
    points.push_back({pilot.at + from, static_cast<double>(at + off) + model.delay_frames});
  }
  return points;
}

}  // namespace tactus
