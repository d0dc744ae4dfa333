#include "latency/estimation/loop_estimator.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "engine/core/index.h"
#include "engine/core/median.h"

namespace tactus {
namespace {

constexpr Seconds kLoopEstimatorQuiet{0.5};  // as much silence as is used
constexpr Seconds kAir{0.005};               // before the first burst is captured
constexpr Seconds kRinging{0.1};             // after the last one
constexpr Seconds kLoopEstimatorShortestQuiet{0.1};
constexpr double kFarLouder = 4.0;       // power
constexpr std::size_t kLeastProbes = 3;  // their spacing identifies them
constexpr std::int64_t kLoopEstimatorSearch = 8192;
constexpr double kLeastStep = 0.75;              // frames
constexpr double kLoopEstimatorCertain = 6.0;    // standard deviations
constexpr double kLoopEstimatorSilence = 1e-10;  // of the captured power: noise below -100 dB does not matter
constexpr double kFaintest = -14.0;              // log gain: -122 dB, below the resolution of any converter
// A hum or a click, which the model can follow only with a gain that nothing has, and leaves most of.
constexpr double kStrongest = 14.0, kHum = 0.5;
constexpr double kNothing = 1e-18;        // -180 dBFS, below what a float sample of full scale can hold
constexpr double kDamaged = 0.05;         // of a probe's power, more than other probes leave unexplained
constexpr double kTouched = 1e-3;         // the same, for a probe that is reported but still used
constexpr double kNoisier = 1.5;          // than other probes is one that something happened to
constexpr std::int64_t kSamePlace = 128;  // frames
constexpr double kFitsWell = 1e-3;        // misfit of a cable
constexpr int kDriftRounds = 3;

/// Of a converter of 16 or 24 bits, if all samples are its steps.
double rounding_variance(std::span<const double> samples) {
  for (const double steps : {0x1p15, 0x1p23})
    if (std::all_of(samples.begin(), samples.end(),
                    [&](double sample) { return std::rint(sample * steps) == sample * steps; }))
      return 1.0 / (12.0 * steps * steps);
  return 0.0;
}

double power(std::span<const double> samples, double mean) {
  double sum = 0.0;
  for (const double sample : samples) sum += (sample - mean) * (sample - mean);
  return samples.empty() ? 0.0 : sum / static_cast<double>(samples.size());
}

double usual(double TrackedProbe::*of, const std::vector<TrackedProbe>& probes) {
  std::vector<double> all;
  for (const auto& probe : probes) all.push_back(probe.*of);
  return median(std::move(all));
}

/// Sweeps in which nothing is broken: those that leave about as much unexplained as the others.
std::vector<TrackedProbe> whole_ones(const std::vector<TrackedProbe>& probes) {
  const double most = usual(&TrackedProbe::misfit, probes) + kDamaged;
  std::vector<TrackedProbe> whole;
  for (const auto& probe : probes)
    if (probe.misfit <= most) whole.push_back(probe);
  return whole;
}

/// What can be separated from noise; but half a frame of noise is not a lost frame.
double least_step(const std::vector<TrackedProbe>& probes) {
  double widest = 0.0;
  for (const auto& probe : probes) widest = std::max(widest, probe.deviation_frames);
  return std::max(kLeastStep, kLoopEstimatorCertain * widest);
}

std::vector<DelayPoint> points_of(const std::vector<TrackedProbe>& probes, double delay) {
  std::vector<DelayPoint> points;
  for (const auto& probe : probes) points.push_back({probe.burst.at, delay + probe.delay_frames});
  return points;
}

/// What a path of these taps makes of `played`; without taps a cable.
std::vector<double> through(const std::vector<double>& played, std::span<const double> taps) {
  if (taps.empty()) return played;
  Fourier fourier{played.size() + taps.size()};
  auto spectrum = fourier.forward(played);
  const auto path = fourier.forward(taps);
  for (std::size_t b = 0; b < spectrum.size(); ++b) spectrum[b] *= path[b];
  auto captured = fourier.inverse(spectrum);
  captured.resize(played.size());
  return captured;
}

std::int64_t reach(const CoarseDelay& coarse) { return coarse.clear() ? kLoopEstimatorSearch : 0; }

// ---- the pilot

constexpr std::int64_t kPart = 2048;
constexpr std::int64_t kPilotReach = 4096;
constexpr std::int64_t kPilotLead = 64;  // what a filter may answer before its delay
constexpr double kProminent = 10.0;

/// What the path would bring, from `kPilotLead` frames before its delay on.
std::vector<double> expected_pilot(std::span<const double> pilot, const PathModel& model,
                                   std::span<const double> profile) {
  Fourier fourier{pilot.size() + profile.size() + 2 * kPilotLead};
  auto placed = model;
  placed.delay_frames += static_cast<double>(kPilotLead);
  const auto path = placed.spectrum(fourier.size(), profile.empty() ? Spectrum{} : fourier.forward(profile));
  auto spectrum = fourier.forward(pilot);
  for (std::size_t b = 0; b < spectrum.size(); ++b) spectrum[b] *= path[b];
  auto signal = fourier.inverse(spectrum);
  signal.resize(pilot.size() + 2 * kPilotLead);
  return signal;
}

std::vector<double> cut(std::span<const double> all, std::int64_t from, std::int64_t frames) {
  std::vector<double> part(index(frames), 0.0);
  const auto end = std::min(from + frames, static_cast<std::int64_t>(all.size()));
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
                                       std::int64_t begin, double variance) {
  constexpr std::int64_t kBlock = 64;
  constexpr std::int64_t kMaxBlocks = 40;  // blocks; what lasts longer is a gain that changes
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

/// What was captured of the pilot.
struct PilotTrack {
  std::vector<DelayPoint> points;  ///< of each part that was recorded and found
  double least_step = 0.0;         ///< frames: less may be noise, or a path that the model does not know well
  std::vector<std::int64_t>
      damage;  ///< frames of the recording where for a moment something else is captured
};

/// In parts: where 2048 frames of it, as the path would bring them, are captured within 4096
/// frames of the delay `at`, to the frame. `variance`: of a frame of noise.
PilotTrack track_pilot(std::span<const double> played, std::span<const double> captured, const Burst& pilot,
                       std::int64_t at, const PathModel& model, std::span<const double> profile,
                       double variance) {
  const auto whole = expected_pilot(played.subspan(index(pilot.at), index(pilot.frames)), model, profile);
  Fourier fourier{index(kPart + 2 * kPilotReach)};
  PilotTrack track;
  for (std::int64_t from = 0; from + kPart <= pilot.frames; from += kPart / 2) {
    const auto begin = pilot.at + at + from - kPilotLead;
    if (begin < 0 || begin + kPart > static_cast<std::int64_t>(captured.size())) continue;
    const auto part = fourier.forward(cut(whole, from, kPart));
    if (track.least_step == 0.0) track.least_step = least_step_of(part, fourier.size(), variance);
    auto cross = fourier.forward(cut(captured, begin - kPilotReach, kPart + 2 * kPilotReach));
    for (std::size_t b = 0; b < cross.size(); ++b) cross[b] *= std::conj(part[b]);
    auto correlation = fourier.inverse(cross);
    correlation.resize(index(2 * kPilotReach));
    const auto highest = std::max_element(correlation.begin(), correlation.end());
    if (!(*highest > kProminent * robust_deviation(correlation))) continue;
    const auto off = highest - correlation.begin() - kPilotReach;
    track.points.push_back({pilot.at + from, static_cast<double>(at + off) + model.delay_frames});
  }
  track.points = without_outliers(track.points);
  track.damage = pilot_damage(whole, captured, pilot.at + at - kPilotLead, variance);
  for (auto& frame : track.damage) frame -= at;
  return track;
}

}  // namespace

LoopEstimator::LoopEstimator(const LoopRecording& recorded, const AnalysisSettings& asked,
                             const PlayedBursts& bursts)
    : recording(recorded),
      settings(asked),
      rate(recorded.sample_rate),
      captured(recorded.captured[index(asked.channel)]),
      profile(asked.profile ? std::span<const double>{asked.profile->taps} : std::span<const double>{}),
      windows(bursts, rate, profile),
      search(through(recorded.played, profile), captured.size(), rate),
      bursts_(bursts) {}

LoopEstimate LoopEstimator::estimate() {
  LoopEstimate loop;
  locate(loop);
  if (!loop.coarse.found() || loop.cut_short) return loop;
  align(loop);
  fit(loop);
  if (loop.found && loop.coarse.clear()) compare(loop);
  return loop;
}

void LoopEstimator::locate(LoopEstimate& loop) {
  loop.bursts = bursts_;
  loop.coarse = search.find(captured);
  loop.floor = noise_floor(loop.coarse);
  windows.set_noise(loop.floor);
  if (!loop.coarse.found()) return;
  const auto recorded = static_cast<std::int64_t>(captured.size());
  auto& repeated = loop.bursts.repeated;
  const auto needed = std::min(repeated.size(), kLeastProbes);
  std::erase_if(repeated, [&](const Burst& burst) {
    return burst.at + loop.coarse.frames < 0 || burst.end() + loop.coarse.frames > recorded;
  });
  loop.cut_short = repeated.size() < needed;
}

/// The noise where nothing of the probe sounds: the last half second before it; where that behind it, or the
/// ends of the pauses, are far quieter or all there is, those. If nothing was found at all, everything.
NoiseFloor LoopEstimator::quiet(const CoarseDelay& coarse) const {
  const auto frames = [&](Seconds time) { return static_cast<std::int64_t>(frames_in(time, rate)); };
  const auto copy = [&](std::int64_t from, std::int64_t to) {
    const auto part = part_of(captured, from, to);
    return std::vector<double>{part.begin(), part.end()};
  };
  if (!coarse.found()) return NoiseFloor::of(captured);
  auto all = bursts_.repeated;
  all.insert(all.end(), bursts_.others.begin(), bursts_.others.end());
  std::sort(all.begin(), all.end(), [](const Burst& a, const Burst& b) { return a.at < b.at; });
  const auto begin = all.front().at + coarse.frames - frames(kAir);
  const auto end = all.back().end() + coarse.frames + frames(kRinging);
  std::vector<double> between;
  for (std::size_t n = 1; n < all.size(); ++n) {
    const auto pause = all[n].at - all[n - 1].end();
    const auto part = copy(all[n].at + coarse.frames - pause / 3, all[n].at + coarse.frames - frames(kAir));
    between.insert(between.end(), part.begin(), part.end());
  }
  // Something else may sound in one of them.
  std::optional<NoiseFloor> best;
  for (const auto& part : {copy(begin - frames(kLoopEstimatorQuiet), begin),
                           copy(end, end + frames(kLoopEstimatorQuiet)), between}) {
    if (part.size() < index(frames(kLoopEstimatorShortestQuiet))) continue;
    auto found = NoiseFloor::of(part);
    if (!best || best->variance > kFarLouder * found.variance) best = std::move(found);
  }
  return best.value_or(NoiseFloor::of({}));
}

NoiseFloor LoopEstimator::noise_floor(const CoarseDelay& coarse) const {
  auto floor = quiet(coarse);
  const double rounding =
      rounding_variance(captured);  // in digital silence there is none, but beside a probe
  floor.variance = std::max(floor.variance, rounding);
  for (auto& each : floor.per_frame) each = std::max(each, rounding);
  const auto from = bursts_.repeated.front().at + coarse.frames;
  const double signal = power(part_of(captured, from, from + bursts_.repeated.front().frames), floor.mean);
  for (auto& each : floor.per_frame) each = std::max(each, kLoopEstimatorSilence * signal + kNothing);
  return floor;
}

/// Removes the drift between the clocks. The probes are compared with the loudest of them where no model
/// fits, so that it does not matter what the path makes of a probe.
void LoopEstimator::align(LoopEstimate& loop) {
  const auto& repeated = loop.bursts.repeated;
  loop.samples.assign(captured.begin(), captured.end());
  loop.at = loop.coarse.frames;
  for (const auto& burst : repeated) loop.steady.push_back({.burst = burst});
  for (int round = 0; loop.coarse.clear() && round <= kDriftRounds; ++round) {
    loop.probes = windows.track(repeated, loop.samples, loop.at, kLoopEstimatorSearch, loudest_probe(loop));
    const auto whole = whole_ones(loop.probes);
    const auto line = DelayTrend::of(points_of(whole, 0.0), least_step(whole));
    loop.steady.clear();
    for (const auto n : line.longest) loop.steady.push_back(whole[n]);
    const double length = static_cast<double>(whole.back().burst.end() - whole.front().burst.at);
    if (whole.size() < 3 || std::abs(line.slope) * length < 1e-3 ||
        std::abs(line.slope) < 3.0 * line.slope_deviation)
      break;
    loop.speed *= 1.0 + line.slope;
    loop.samples = at_speed(captured, loop.speed);
  }
  loop.at += std::llround(usual(&TrackedProbe::delay_frames, loop.steady));
  // Smeared over many frames, neither its place nor its sign was certain.
  if (loop.speed == 1.0) return;
  loop.coarse = search.find(loop.samples);
  loop.at = loop.coarse.frames;
}

Spectrum LoopEstimator::loudest_probe(const LoopEstimate& loop) {
  const auto& repeated = loop.bursts.repeated;
  const auto loudest = std::max_element(repeated.begin(), repeated.end(),
                                        [](const Burst& a, const Burst& b) { return a.gain < b.gain; });
  const TrackedProbe probe{.burst = *loudest};
  const auto window = windows.mean(loop.samples, loop.at, {&probe, 1});
  return expected(window, fit_of(window, loop.coarse));
}

PathFit LoopEstimator::fit_of(const CapturedWindow& window, const CoarseDelay& coarse) {
  // What a profile knows is not to be guessed again.
  return fit_path(window, windows.start_of(window, coarse.sign, reach(coarse)),
                  settings.profile ? PathShape::Kept : PathShape::Free);
}

/// The model where it fits: it has no noise.
Spectrum LoopEstimator::expected(const CapturedWindow& window, const PathFit& fit) const {
  return fit.misfit < kFits ? windows.expected(fit.model) : ProbeWindows::cleaned(window);
}

void LoopEstimator::fit(LoopEstimate& loop) {
  loop.mean = windows.mean(loop.samples, loop.at, loop.steady);
  const auto off = windows.start_of(loop.mean, loop.coarse.sign, reach(loop.coarse)).delay_frames;
  loop.at += static_cast<std::int64_t>(off);
  if (off != 0.0) loop.mean = windows.mean(loop.samples, loop.at, loop.steady);
  loop.fit = fit_of(loop.mean, loop.coarse);
  loop.noise = loop.floor.variance;
  if (loop.steady.size() > 1)
    loop.noise = std::max(loop.noise, windows.scatter(loop.samples, loop.at, loop.steady, loop.mean));
  // A tone or a click may correlate with a probe, but no path makes one from the other.
  const double gain = loop.fit.model.log_gain;
  const bool nonsense = gain > kStrongest && loop.fit.misfit > kHum;
  loop.found = loop.fit.strength >= CoarseDelay::kNothing && gain >= kFaintest && !nonsense;
}

void LoopEstimator::compare(LoopEstimate& loop) {
  loop.probes = windows.track(loop.bursts.repeated, loop.samples, loop.at, kLoopEstimatorSearch,
                              expected(loop.mean, loop.fit));
  const auto whole = whole_ones(loop.probes);
  loop.trend = DelayTrend::of(points_of(whole, loop.constant()), least_step(whole));
  loop.steps = loop.trend.steps;
  if (const auto pilot = loop.bursts.pilot(rate); pilot && loop.fit.misfit < kFits)
    add_pilot_steps(loop, *pilot, whole);
  if (loop.steps.empty()) find_damage(loop);
}

/// Steps behind the probes, where the pilot sounds.
void LoopEstimator::add_pilot_steps(LoopEstimate& loop, const Burst& pilot,
                                    const std::vector<TrackedProbe>& whole) const {
  const auto track = track_pilot(recording.played, loop.samples, pilot, loop.at, loop.fit.model, profile,
                                 loop.floor.variance);
  std::vector<DelayPoint> points{points_of(whole, loop.constant()).back()};
  points.insert(points.end(), track.points.begin(), track.points.end());
  const auto more = DelayTrend::of(points, std::max(least_step(whole), track.least_step)).steps;
  loop.steps.insert(loop.steps.end(), more.begin(), more.end());
  if (loop.steps.empty() && loop.fit.misfit < kFitsWell && !settings.profile)
    for (const auto place : track.damage) loop.steps.push_back({place, 0.0});
}

/// In a probe that leaves more unexplained than the others, or has something else in it for a moment. What
/// lies at the same place of two probes is no damage: loud and soft ones differ there.
void LoopEstimator::find_damage(LoopEstimate& loop) {
  const auto& probes = loop.probes;
  const double misfit = usual(&TrackedProbe::misfit, probes) + kTouched;
  const double chi_squared = kNoisier * usual(&TrackedProbe::chi_squared, probes);
  struct Damage {
    std::size_t probe;
    std::int64_t frame;
  };
  std::vector<Damage> damage;
  for (std::size_t n = 0; n < probes.size(); ++n) {
    const auto places = windows.damage(loop.samples, loop.at, probes[n], loop.mean, loop.noise);
    for (const auto place : places) damage.push_back({n, place});
    // Of a soft probe, noise is a larger share.
    const bool touched = probes[n].misfit > misfit && probes[n].chi_squared > chi_squared;
    if (places.empty() && touched) damage.push_back({n, probes[n].burst.at});
  }
  const auto offset = [&](const Damage& one) { return one.frame - probes[one.probe].burst.at; };
  for (const auto& one : damage) {
    const bool again = std::any_of(damage.begin(), damage.end(), [&](const Damage& other) {
      return other.probe != one.probe && std::abs(offset(other) - offset(one)) <= kSamePlace;
    });
    if (again)
      loop.overdriven = true;
    else
      loop.steps.push_back({one.frame, 0.0});
  }
}

}  // namespace tactus
