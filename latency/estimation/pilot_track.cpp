#include "latency/estimation/pilot_track.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "engine/core/index.h"
#include "engine/core/median.h"
#include "latency/estimation/fourier.h"
#include "latency/estimation/loop_recording.h"

namespace tactus {
namespace {

constexpr std::int64_t kPiece = 2048;
constexpr std::int64_t kPilotTrackReach = 4096;
constexpr std::int64_t kPilotTrackLead = 64;  // what a filter may answer before its delay
constexpr double kProminent = 10.0;

/// What the path would bring, from `kPilotTrackLead` frames before its delay on.
std::vector<double> expected(std::span<const double> pilot, const PathModel& model,
                             std::span<const double> profile) {
  Fourier fourier{pilot.size() + profile.size() + 2 * kPilotTrackLead};
  auto placed = model;
  placed.delay_frames += static_cast<double>(kPilotTrackLead);
  const auto path = placed.spectrum(fourier.size(), profile.empty() ? Spectrum{} : fourier.forward(profile));
  auto spectrum = fourier.forward(pilot);
  for (std::size_t b = 0; b < spectrum.size(); ++b) spectrum[b] *= path[b];
  auto signal = fourier.inverse(spectrum);
  signal.resize(pilot.size() + 2 * kPilotTrackLead);
  return signal;
}

std::vector<double> cut(std::span<const double> all, std::int64_t from, std::int64_t frames) {
  std::vector<double> piece(index(frames), 0.0);
  const auto end = std::min(from + frames, static_cast<std::int64_t>(all.size()));
  for (auto n = std::max<std::int64_t>(0, from); n < end; ++n) piece[index(n - from)] = all[index(n)];
  return piece;
}

/// Six standard deviations of a piece's delay in that noise; or what a phase that is wrong by a seventh of a
/// radian (2 % of the power) makes of it, twice.
double least_step_of(const Spectrum& piece, std::size_t size, double variance) {
  double energy = 0.0, slope_energy = 0.0;
  for (std::size_t b = 1; b < piece.size(); ++b) {
    const double w = angular_frequency(b, size);
    const double share = 2.0 / static_cast<double>(size) * std::norm(piece[b]);
    energy += share;
    slope_energy += w * w * share;
  }
  return std::max(6.0 * std::sqrt(variance / slope_energy), 0.3 * std::sqrt(energy / slope_energy));
}

/// Frames of `captured` from which on, for less than 50 ms, it is not what is expected from `begin` on.
std::vector<std::int64_t> damage(const std::vector<double>& whole, std::span<const double> captured,
                                 std::int64_t begin, double variance) {
  constexpr std::int64_t kBlock = 64;
  constexpr std::int64_t kLongest = 40;  // blocks; what lasts longer is a gain that changes
  const auto blocks = static_cast<std::int64_t>(whole.size()) / kBlock;
  double usual = 0.0;  // power of a block: at the ends there is less
  for (const double sample : whole) usual += sample * sample * kBlock / static_cast<double>(whole.size());
  const auto broken = [&](std::int64_t block) {
    const auto from = block * kBlock, there = begin + from;
    if (there < 0 || there + kBlock > static_cast<std::int64_t>(captured.size())) return false;
    double explained = 0.0, unexplained = 0.0;
    for (std::int64_t k = 0; k < kBlock; ++k) {
      const double expects = whole[index(from + k)];
      const double rest = captured[index(there + k)] - expects;
      explained += expects * expects;
      unexplained += rest * rest;
    }
    return unexplained > 0.25 * std::max(explained, usual) && unexplained > 36.0 * kBlock * variance;
  };
  auto places = short_runs(blocks, kLongest, broken);
  for (auto& place : places) place = begin + place * kBlock;
  return places;
}

/// Each place by the middle one of three. A step stays where it is; a piece that was taken for its neighbour,
/// an oscillation beside it, does not count. The ends have no two neighbours, and are left out.
std::vector<DelayPoint> without_outliers(const std::vector<DelayPoint>& points) {
  std::vector<DelayPoint> quiet;
  for (std::size_t n = 1; n + 1 < points.size(); ++n)
    quiet.push_back({points[n].played_at, median({points[n - 1].delay_frames, points[n].delay_frames,
                                                  points[n + 1].delay_frames})});
  return quiet;
}

}  // namespace

PilotTrack track_pilot(std::span<const double> played, std::span<const double> captured, const Burst& pilot,
                       std::int64_t at, const PathModel& model, std::span<const double> profile,
                       double variance) {
  const auto whole = expected(played.subspan(index(pilot.at), index(pilot.frames)), model, profile);
  Fourier fourier{index(kPiece + 2 * kPilotTrackReach)};
  PilotTrack track;
  for (std::int64_t from = 0; from + kPiece <= pilot.frames; from += kPiece / 2) {
    const auto begin = pilot.at + at + from - kPilotTrackLead;
    if (begin < 0 || begin + kPiece > static_cast<std::int64_t>(captured.size())) continue;
    const auto piece = fourier.forward(cut(whole, from, kPiece));
    if (track.least_step == 0.0) track.least_step = least_step_of(piece, fourier.size(), variance);
    auto cross = fourier.forward(cut(captured, begin - kPilotTrackReach, kPiece + 2 * kPilotTrackReach));
    for (std::size_t b = 0; b < cross.size(); ++b) cross[b] *= std::conj(piece[b]);
    auto correlation = fourier.inverse(cross);
    correlation.resize(index(2 * kPilotTrackReach));
    const auto highest = std::max_element(correlation.begin(), correlation.end());
    if (!(*highest > kProminent * robust_deviation(correlation))) continue;
    const auto off = highest - correlation.begin() - kPilotTrackReach;
    track.points.push_back({pilot.at + from, static_cast<double>(at + off) + model.delay_frames});
  }
  track.points = without_outliers(track.points);
  track.damage = damage(whole, captured, pilot.at + at - kPilotTrackLead, variance);
  for (auto& frame : track.damage) frame -= at;
  return track;
}

}  // namespace tactus
