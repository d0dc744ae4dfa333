#include "latency/estimation/pilot_track.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "engine/core/index.h"
#include "engine/core/median.h"
#include "latency/estimation/loop_recording.h"

namespace tactus {
namespace {

constexpr std::int64_t kPart = 2048;
constexpr std::int64_t kPilotReach = 4096;
constexpr std::int64_t kMarkReach = 8192;
constexpr double kProminent = 10.0;  // standard deviations
constexpr double kMarkExpected = 14.0;
constexpr double kInPlace = 7.0;        // the same, where it is expected
constexpr double kMarkLowest = 0.003;   // of the sample rate, as probes are fitted
constexpr double kMarkFaintest = 1e-3;  // of its mean power: a resampled mark has less above its own band
constexpr double kBlockCertain = 4.0;   // independent values in a block
constexpr double kReplaced = 0.6;       // of the amplitude: less is kept
constexpr double kReplacedCertain = 6.0;

std::vector<double> cut(std::span<const double> all, std::int64_t from, std::int64_t frames) {
  std::vector<double> part(index(frames), 0.0);
  const auto end = std::min(from + frames, std::ssize(all));
  for (auto n = std::max<std::int64_t>(0, from); n < end; ++n) part[index(n - from)] = all[index(n)];
  return part;
}

/// Six standard deviations of a part's delay in that noise; or what a phase that is wrong by a seventh of a
/// radian (2 % of the power) makes of it, twice.
double least_step_of(const Spectrum& part, std::size_t size, double variance) {
  double energy = 0.0, slope_energy = 0.0;
  for (std::size_t b = 1; b < part.size(); ++b) {
    const double w = angular_frequency(b, size);
    const double share = 2.0 / static_cast<double>(size) * std::norm(part[b]);
    energy += share;
    slope_energy += w * w * share;
  }
  return std::max(6.0 * std::sqrt(variance / slope_energy), 0.3 * std::sqrt(energy / slope_energy));
}

/// Frames of `captured` from which on, for less than 50 ms, it is not what is expected from `begin` on.
std::vector<std::int64_t> pilot_damage(const std::vector<double>& whole, std::span<const double> captured,
                                       std::int64_t begin, double variance, double certainty) {
  constexpr std::int64_t kBlock = 64, kShift = 8;
  constexpr std::int64_t kMaxBlocks = 40;  // what lasts longer is a gain that changes
  const auto blocks = std::ssize(whole) / kBlock;
  double usual = 0.0;  // power of a block: at the ends there is less
  for (const double sample : whole) usual += sample * sample * kBlock / static_cast<double>(whole.size());
  const auto replaced = [&](std::int64_t from) {
    const auto expected = part_of(whole, from, from + kBlock);
    return std::ssize(expected) == kBlock &&
           Damage::of(part_of(captured, begin + from, begin + from + kBlock), expected).replaced(certainty);
  };
  const auto broken = [&](std::int64_t block) {
    const auto from = block * kBlock;
    const auto there = part_of(captured, begin + from, begin + from + kBlock);
    if (begin + from < 0 || std::ssize(there) < kBlock) return false;
    double explained = 0.0, unexplained = 0.0;
    for (std::size_t k = 0; k < there.size(); ++k) {
      const double expects = whole[index(from) + k], rest = there[k] - expects;
      explained += expects * expects;
      unexplained += rest * rest;
    }
    if (!(unexplained > 0.25 * std::max(explained, usual) && unexplained > 36.0 * kBlock * variance))
      return false;
    // What is replaced may begin within the block before or this one.
    for (auto shift = -kBlock + kShift; shift < kBlock; shift += kShift)
      if (begin + from + shift >= 0 && from + shift >= 0 && replaced(from + shift)) return true;
    return false;
  };
  auto places = short_runs(blocks, kMaxBlocks, broken);
  for (auto& place : places) place = begin + place * kBlock;
  return places;
}

/// Each place by the middle one of three. A step stays where it is; a part that was taken for its neighbour,
/// an oscillation beside it, does not count. The ends have no two neighbours, and are left out.
std::vector<DelayPoint> without_outliers(const std::vector<DelayPoint>& points) {
  std::vector<DelayPoint> quiet;
  for (std::size_t n = 1; n + 1 < points.size(); ++n)
    quiet.push_back({points[n].played_at, median({points[n - 1].delay_frames, points[n].delay_frames,
                                                  points[n + 1].delay_frames})});
  return quiet;
}

/// Both, each frequency weighted so that the stronger of them is as strong everywhere. What is expected and
/// not captured, as at the upper end of a resampled signal, counts no more than any other frequency.
struct Whitened {
  std::vector<double> captured, expected;
  double share = 0.0;  ///< of all frequencies, those that count

  /// `signal`: what the path makes of `sound`, expected `before` frames behind the begin of `region`. Where
  /// nothing was played the model of the path is a guess, and nothing counts.
  Whitened(std::span<const double> region, std::span<const double> signal, std::span<const double> sound,
           std::int64_t before) {
    Fourier fourier{region.size() + signal.size()};
    auto of_captured = fourier.forward(region);
    std::vector<double> placed(index(before), 0.0);
    placed.insert(placed.end(), signal.begin(), signal.end());
    auto of_expected = fourier.forward(placed);
    const auto power = smoothed_power(of_captured), expects = smoothed_power(of_expected),
               played = smoothed_power(fourier.forward(sound));
    const auto mean_of = [](const std::vector<double>& all) {
      return std::accumulate(all.begin(), all.end(), 0.0) / static_cast<double>(all.size());
    };
    const double mean = mean_of(power), least = kMarkFaintest * mean_of(played);
    const auto lowest = static_cast<std::size_t>(kMarkLowest * static_cast<double>(fourier.size()));
    for (std::size_t b = 0; b < power.size(); ++b) {
      const bool heard = b >= lowest && played[b] > least;
      const double weight =
          heard ? 1.0 / std::sqrt(std::max(power[b], expects[b]) + 1e-9 * mean + 1e-300) : 0.0;
      share += heard ? 1.0 / static_cast<double>(power.size()) : 0.0;
      of_captured[b] *= weight;
      of_expected[b] *= weight;
    }
    captured = fourier.inverse(of_captured);
    expected = fourier.inverse(of_expected);
  }

  /// How much more of it is captured with each lag from -reach to +reach, in standard deviations of the lags
  /// from `first` on; `full`: with all of it, at the lag 0.
  std::vector<double> prominence(std::int64_t reach, std::int64_t first, double& full) const {
    Fourier fourier{captured.size()};
    auto cross = fourier.forward(captured);
    const auto other = fourier.forward(expected);
    for (std::size_t b = 0; b < cross.size(); ++b) cross[b] *= std::conj(other[b]);
    const auto circle = fourier.inverse(cross);
    const auto size = std::ssize(circle);
    std::vector<double> lags;
    for (auto lag = -reach; lag <= reach; ++lag) lags.push_back(circle[index((lag + size) % size)]);
    const auto counted = part_of(lags, reach + first, std::ssize(lags));
    const double deviation = std::max(robust_deviation({counted.begin(), counted.end()}), 1e-300);
    for (auto& each : lags) each /= deviation;
    full = product(expected, expected) / deviation;
    return lags;
  }

  /// Is a part from either end missing, of at least 32 independent values?
  bool cut_short(std::int64_t from, std::int64_t to) const {
    const auto least = std::llround(32.0 / std::max(share, 1e-3));
    double expects = 0.0, finds = 0.0;
    std::vector<double> beside;
    for (auto n = from; n < to; ++n) beside.push_back(captured[index(n)] - expected[index(n)]);
    const double rest = robust_deviation(std::move(beside));
    const auto missing = [&](std::int64_t n) {
      expects += expected[index(n)] * expected[index(n)];
      finds += expected[index(n)] * captured[index(n)];
      const double lost = 1.0 - finds / expects;
      return lost > 1.0 - kReplaced && lost * std::sqrt(expects) > kReplacedCertain * rest;
    };
    for (auto n = from; n < to; ++n)
      if (missing(n) && n - from >= least) return true;
    expects = finds = 0.0;
    for (auto n = to; n-- > from;)
      if (missing(n) && to - n >= least) return true;
    return false;
  }
};

}  // namespace

std::span<const double> SingleBurst::sound() const { return part_of(played, burst.at, burst.end()); }

std::vector<double> SingleBurst::expected() const {
  Fourier fourier{sound().size() + profile.size() + 2 * kLead};
  auto placed = model;
  placed.delay_frames += static_cast<double>(kLead);
  const auto path = placed.spectrum(fourier.size(), profile.empty() ? Spectrum{} : fourier.forward(profile));
  auto spectrum = fourier.forward(sound());
  for (std::size_t b = 0; b < spectrum.size(); ++b) spectrum[b] *= path[b];
  auto signal = fourier.inverse(spectrum);
  signal.resize(sound().size() + 2 * kLead);
  return signal;
}

Damage Damage::of(std::span<const double> captured, std::span<const double> expected) {
  const double power = std::max(product(expected, expected), 1e-300);
  Damage damage;
  damage.kept = product(captured, expected) / power;
  damage.unexplained = std::max(0.0, product(captured, captured) / power - damage.kept * damage.kept);
  return damage;
}

bool Damage::replaced(double certainty) const {
  return kept + 3.0 * std::sqrt(unexplained / certainty) < 0.8;
}

PilotTrack track_pilot(const SingleBurst& pilot, std::span<const double> captured, double variance,
                       bool unsteady) {
  const auto whole = pilot.expected();
  Fourier fourier{index(kPart + 2 * kPilotReach)};
  PilotTrack track;
  for (std::int64_t from = 0; from + kPart <= pilot.burst.frames; from += kPart / 2) {
    const auto begin = pilot.begin() + from;
    if (begin < 0 || begin + kPart > std::ssize(captured)) continue;
    const auto part = fourier.forward(cut(whole, from, kPart));
    if (track.least_step == 0.0) track.least_step = least_step_of(part, fourier.size(), variance);
    auto cross = fourier.forward(cut(captured, begin - kPilotReach, kPart + 2 * kPilotReach));
    for (std::size_t b = 0; b < cross.size(); ++b) cross[b] *= std::conj(part[b]);
    auto correlation = fourier.inverse(cross);
    correlation.resize(index(2 * kPilotReach));
    const auto highest = std::max_element(correlation.begin(), correlation.end());
    if (!(*highest > kProminent * robust_deviation(correlation))) continue;
    const auto off = highest - correlation.begin() - kPilotReach;
    track.points.push_back(
        {pilot.burst.at + from, static_cast<double>(pilot.at + off) + pilot.model.delay_frames});
  }
  track.points = without_outliers(track.points);
  track.damage = pilot_damage(whole, captured, pilot.begin(), variance, unsteady ? 1.0 : kBlockCertain);
  for (auto& frame : track.damage) frame -= pilot.at;
  return track;
}

MarkTrack track_mark(const SingleBurst& mark, std::span<const double> captured, std::int64_t longest) {
  MarkTrack track;
  const auto begin = mark.begin();
  const auto whole = mark.expected();
  const auto length = std::ssize(whole);
  if (begin + kMarkReach < 0 || begin + length > std::ssize(captured)) return track;
  // Where more frames were lost than the delay has, it is captured later than the recording begins.
  const auto expected = begin + SingleBurst::kLead;
  const auto before = std::clamp<std::int64_t>(expected, 0, kMarkReach) + SingleBurst::kLead;
  const auto behind = std::min(longest, kMarkReach);
  const Whitened white{cut(captured, begin - before, before + length + behind), whole, mark.sound(), before};
  const auto reach = std::max(before, behind);
  // Before the recording begins nothing is captured, not even noise.
  const auto first = expected < 0 ? -expected : -reach;
  double full = 0.0;
  const auto found = white.prominence(reach, first, full);
  const auto highest = std::max_element(found.begin(), found.end());
  if (expected < 0 && !(*highest > kProminent && highest - found.begin() >= reach + first)) return track;
  track.recorded = true;
  const bool in_place = found[index(reach)] > kInPlace;
  track.judged = in_place || full > kMarkExpected || *highest > kProminent;
  if (!track.judged) return track;
  const auto off = highest - found.begin() - reach;
  if (!in_place && *highest < kProminent)
    track.steps.push_back({mark.burst.at, 0.0});
  else if (off != 0)
    track.steps.push_back({mark.burst.end(), static_cast<double>(-off)});
  else if (white.cut_short(before + SingleBurst::kLead, before + length - SingleBurst::kLead))
    track.steps.push_back({mark.burst.at, 0.0});
  return track;
}

}  // namespace tactus
