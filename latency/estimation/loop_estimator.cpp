#include "latency/estimation/loop_estimator.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/core/median.h"
#include "latency/estimation/pilot_track.h"

namespace tactus {
namespace {

constexpr Seconds kLoopEstimatorQuiet{0.5};  // as much silence as is listened to
constexpr Seconds kAir{0.005};               // before the first burst is heard
constexpr Seconds kRinging{0.1};             // after the last one
constexpr Seconds kLoopEstimatorShortestQuiet{0.1};
constexpr double kFarLouder = 4.0;       // power
constexpr std::size_t kLeastSweeps = 3;  // their spacing tells which of them they are
constexpr std::int64_t kLoopEstimatorSearch = 8192;
constexpr double kLeastStep = 0.75;            // frames
constexpr double kLoopEstimatorCertain = 6.0;  // standard deviations
constexpr double kLoopEstimatorSilence =
    1e-10;                           // of the heard power: noise below -100 dB is no help to anybody
constexpr double kFaintest = -14.0;  // log gain: -122 dB, where no converter hears anything
// A hum or a click, which the model can follow only with a gain that nothing has, and leaves most of.
constexpr double kStrongest = 14.0, kHum = 0.5;
constexpr double kNothing = 1e-18;        // -180 dBFS, below what a float sample of full scale can hold
constexpr double kDamaged = 0.05;         // of a sweep's power, more than other sweeps leave unexplained
constexpr double kTouched = 1e-3;         // the same, for a sweep that is told of but still used
constexpr double kNoisier = 1.5;          // than other sweeps is one that something happened to
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

double usual(double TrackedSweep::*of, const std::vector<TrackedSweep>& sweeps) {
  std::vector<double> all;
  for (const auto& sweep : sweeps) all.push_back(sweep.*of);
  return median(std::move(all));
}

/// Sweeps in which nothing is broken: those that leave about as much unexplained as the others.
std::vector<TrackedSweep> whole_ones(const std::vector<TrackedSweep>& sweeps) {
  const double most = usual(&TrackedSweep::misfit, sweeps) + kDamaged;
  std::vector<TrackedSweep> whole;
  for (const auto& sweep : sweeps)
    if (sweep.misfit <= most) whole.push_back(sweep);
  return whole;
}

/// What can be told from noise; but half a frame of noise is not a lost frame.
double least_step(const std::vector<TrackedSweep>& sweeps) {
  double widest = 0.0;
  for (const auto& sweep : sweeps) widest = std::max(widest, sweep.deviation_frames);
  return std::max(kLeastStep, kLoopEstimatorCertain * widest);
}

std::vector<DelayPoint> points_of(const std::vector<TrackedSweep>& sweeps, double delay) {
  std::vector<DelayPoint> points;
  for (const auto& sweep : sweeps) points.push_back({sweep.burst.at, delay + sweep.delay_frames});
  return points;
}

/// What a path of these taps makes of `played`; without taps a cable.
std::vector<double> through(const std::vector<double>& played, std::span<const double> taps) {
  if (taps.empty()) return played;
  Fourier fourier{played.size() + taps.size()};
  auto spectrum = fourier.forward(played);
  const auto path = fourier.forward(taps);
  for (std::size_t b = 0; b < spectrum.size(); ++b) spectrum[b] *= path[b];
  auto heard = fourier.inverse(spectrum);
  heard.resize(played.size());
  return heard;
}

}  // namespace

LoopEstimator::LoopEstimator(const LoopRecording& of, const AnalysisSettings& with, PlayedBursts played)
    : recording(of),
      settings(with),
      bursts(std::move(played)),
      heard(of.heard[static_cast<std::size_t>(with.channel)]),
      windows(bursts, of.sample_rate, profile_taps()),
      search_(through(of.played, profile_taps()), heard.size(), of.sample_rate) {}

std::span<const double> LoopEstimator::profile_taps() const {
  return settings.profile ? std::span<const double>{settings.profile->taps} : std::span<const double>{};
}

std::vector<CoarseDelay> LoopEstimator::every_channel() {
  std::vector<CoarseDelay> all;
  for (const auto& channel : recording.heard) all.push_back(search_.find(channel));
  return all;
}

bool LoopEstimator::find() {
  coarse = search_.find(heard);
  listen_to_quiet();
  if (!coarse.found()) return false;
  const auto recorded = static_cast<std::int64_t>(heard.size());
  const auto needed = std::min(bursts.repeated.size(), kLeastSweeps);
  std::erase_if(bursts.repeated, [&](const Burst& burst) {
    return burst.at + coarse.frames < 0 || burst.end() + coarse.frames > recorded;
  });
  cut_short = bursts.repeated.size() < needed;
  return !cut_short;
}

/// Where nothing of what was played is heard: the last half second before it; where that behind it, or the
/// ends of the pauses, are far quieter or all there is, those. If nothing is heard at all, everything.
NoiseFloor LoopEstimator::quiet() const {
  const auto frames = [&](Seconds time) { return static_cast<std::int64_t>(frames_in(time, rate())); };
  const auto copy = [&](std::int64_t from, std::int64_t to) {
    const auto piece = stretch(heard, from, to);
    return std::vector<double>{piece.begin(), piece.end()};
  };
  if (!coarse.found()) return NoiseFloor::of(heard);
  auto all = bursts.repeated;
  all.insert(all.end(), bursts.others.begin(), bursts.others.end());
  std::sort(all.begin(), all.end(), [](const Burst& a, const Burst& b) { return a.at < b.at; });
  const auto begin = all.front().at + coarse.frames - frames(kAir);
  const auto end = all.back().end() + coarse.frames + frames(kRinging);
  std::vector<double> between;
  for (std::size_t n = 1; n < all.size(); ++n) {
    const auto pause = all[n].at - all[n - 1].end();
    const auto piece = copy(all[n].at + coarse.frames - pause / 3, all[n].at + coarse.frames - frames(kAir));
    between.insert(between.end(), piece.begin(), piece.end());
  }
  // Something else may sound in one of them.
  std::optional<NoiseFloor> best;
  for (const auto& piece : {copy(begin - frames(kLoopEstimatorQuiet), begin),
                            copy(end, end + frames(kLoopEstimatorQuiet)), between}) {
    if (piece.size() < static_cast<std::size_t>(frames(kLoopEstimatorShortestQuiet))) continue;
    auto found = NoiseFloor::of(piece);
    if (!best || best->variance > kFarLouder * found.variance) best = std::move(found);
  }
  return best.value_or(NoiseFloor::of({}));
}

void LoopEstimator::listen_to_quiet() {
  floor = quiet();
  const double rounding = rounding_variance(heard);  // in digital silence there is none, but beside a sweep
  floor.variance = std::max(floor.variance, rounding);
  for (auto& each : floor.per_frame) each = std::max(each, rounding);
  const auto from = bursts.repeated.front().at + coarse.frames;
  const double signal = power(stretch(heard, from, from + bursts.repeated.front().frames), floor.mean);
  for (auto& each : floor.per_frame) each = std::max(each, kLoopEstimatorSilence * signal + kNothing);
  windows.set_noise(floor);
}

/// The sweeps are compared with the loudest of them where no model fits, so that it does not matter what the
/// path makes of a sweep.
void LoopEstimator::follow_clock() {
  steady_heard = heard;
  for (const auto& burst : bursts.repeated) steady.push_back({.burst = burst});
  at = coarse.frames;
  for (int round = 0; coarse.clear() && round <= kDriftRounds; ++round) {
    sweeps = windows.track(steady_heard, at, kLoopEstimatorSearch, loudest_sweep());
    const auto whole = whole_ones(sweeps);
    const auto line = DelayTrend::of(points_of(whole, 0.0), least_step(whole));
    steady.clear();
    for (const auto n : line.longest) steady.push_back(whole[n]);
    const double length = static_cast<double>(whole.back().burst.end() - whole.front().burst.at);
    if (whole.size() < 3 || std::abs(line.slope) * length < 1e-3 ||
        std::abs(line.slope) < 3.0 * line.slope_deviation)
      break;
    speed *= 1.0 + line.slope;
    steadied_ = at_speed(heard, speed);
    steady_heard = steadied_;
  }
  at += std::llround(middle_delay());
  // Smeared over many frames, neither its place nor its sign was certain.
  if (speed == 1.0) return;
  coarse = search_.find(steady_heard);
  at = coarse.frames;
}

Spectrum LoopEstimator::loudest_sweep() {
  const auto loudest = std::max_element(bursts.repeated.begin(), bursts.repeated.end(),
                                        [](const Burst& a, const Burst& b) { return a.gain < b.gain; });
  const TrackedSweep sweep{.burst = *loudest};
  const auto window = windows.mean(steady_heard, at, {&sweep, 1});
  return expected(window, fit_of(window));
}

std::int64_t LoopEstimator::reach() const { return coarse.clear() ? kLoopEstimatorSearch : 0; }

PathFit LoopEstimator::fit_of(const HeardWindow& window) {
  // What a profile knows is not to be guessed again.
  return fit_path(window, windows.start_of(window, coarse.sign, reach()),
                  settings.profile ? PathShape::Kept : PathShape::Free);
}

/// The model where it fits: it has no noise.
Spectrum LoopEstimator::expected(const HeardWindow& window, const PathFit& fit) const {
  return fit.misfit < kFits ? windows.expected(fit.model) : SweepWindows::cleaned(window);
}

bool LoopEstimator::fit() {
  mean = windows.mean(steady_heard, at, steady);
  const auto off = windows.start_of(mean, coarse.sign, reach()).delay_frames;
  at += static_cast<std::int64_t>(off);
  if (off != 0.0) mean = windows.mean(steady_heard, at, steady);
  fitted = fit_of(mean);
  noise = floor.variance;
  if (steady.size() > 1) noise = std::max(noise, windows.scatter(steady_heard, at, steady, mean));
  // A tone or a click may correlate with a sweep, but no path makes one from the other.
  const double gain = fitted.model.log_gain;
  const bool nonsense = gain > kStrongest && fitted.misfit > kHum;
  return fitted.strength >= CoarseDelay::kNothing && gain >= kFaintest && !nonsense;
}

double LoopEstimator::middle_delay() const {
  std::vector<double> delays;
  for (const auto& sweep : steady) delays.push_back(sweep.delay_frames);
  return median(std::move(delays));
}

void LoopEstimator::compare_sweeps() {
  sweeps = windows.track(steady_heard, at, kLoopEstimatorSearch, expected(mean, fitted));
  const auto whole = whole_ones(sweeps);
  trend = DelayTrend::of(points_of(whole, constant()), least_step(whole));
  find_steps(whole);
}

/// Sweeps and, behind them, the pilot in pieces.
void LoopEstimator::find_steps(const std::vector<TrackedSweep>& whole) {
  steps = trend.steps;
  const auto pilot = bursts.pilot(rate());
  if (pilot && fitted.misfit < kFits) {
    const auto heard_of_it =
        track_pilot(recording.played, steady_heard, *pilot, at, fitted.model, profile_taps(), floor.variance);
    std::vector<DelayPoint> points{points_of(whole, constant()).back()};
    points.insert(points.end(), heard_of_it.points.begin(), heard_of_it.points.end());
    const auto least = std::max(least_step(whole), heard_of_it.least_step);
    const auto more = DelayTrend::of(points, least).steps;
    steps.insert(steps.end(), more.begin(), more.end());
    if (steps.empty() && fitted.misfit < kFitsWell && !settings.profile)
      for (const auto place : heard_of_it.damage) steps.push_back({place, 0.0});
  }
  if (steps.empty()) find_damage();
}

/// In a sweep that leaves more unexplained than the others, or has something else in it for a moment. What
/// stands at the same place of two sweeps is no damage: loud and soft ones differ there.
void LoopEstimator::find_damage() {
  const double misfit = usual(&TrackedSweep::misfit, sweeps) + kTouched;
  const double chi_squared = kNoisier * usual(&TrackedSweep::chi_squared, sweeps);
  struct Damage {
    std::size_t sweep;
    std::int64_t frame;
  };
  std::vector<Damage> damage;
  for (std::size_t n = 0; n < sweeps.size(); ++n) {
    const auto places = windows.damage(steady_heard, at, sweeps[n], mean, noise);
    for (const auto place : places) damage.push_back({n, place});
    // Of a soft sweep, noise is a larger share.
    const bool touched = sweeps[n].misfit > misfit && sweeps[n].chi_squared > chi_squared;
    if (places.empty() && touched) damage.push_back({n, sweeps[n].burst.at});
  }
  const auto offset = [&](const Damage& one) { return one.frame - sweeps[one.sweep].burst.at; };
  for (const auto& one : damage) {
    const bool again = std::any_of(damage.begin(), damage.end(), [&](const Damage& other) {
      return other.sweep != one.sweep && std::abs(offset(other) - offset(one)) <= kSamePlace;
    });
    if (again)
      overdriven = true;
    else
      steps.push_back({one.frame, 0.0});
  }
}

}  // namespace tactus
