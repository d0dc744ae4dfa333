#include "latency/estimation/loop_estimator.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "engine/core/index.h"
#include "engine/core/median.h"
#include "latency/estimation/probe_damage.h"

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
constexpr double kKnock = 2.0;        // log gain: 17 dB over that of the other probes
constexpr double kNothing = 1e-18;    // -180 dBFS, below what a float sample of full scale can hold
constexpr double kDamaged = 0.05;     // of a probe's power, more than other probes leave unexplained
constexpr double kMoreDamaged = 1.5;  // the same, times what others leave
constexpr double kNoNoise = 10.0;     // power over what other probes leave
constexpr Seconds kLongestDamage{0.02};
constexpr std::size_t kManyProbes = 4;  // by how they differ, the noise is known
constexpr double kUnsteady = 2.0;       // power
constexpr double kElsewhere = 0.5;      // of the amplitude
constexpr double kLoudPilot = 10.0;     // power over that of the noise
constexpr double kFitsWell = 1e-3;      // misfit of a cable
constexpr double kCable = 5e-3;         // the same beside a sound that is nearly as loud
constexpr int kDriftRounds = 3;
constexpr double kClearest = 0.01;  // noise over signal: bands that are clearer count alike

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

/// What a sweep in which nothing is broken leaves unexplained: about as much as the others.
double most_misfit(const std::vector<TrackedProbe>& probes) {
  return kMoreDamaged * usual(&TrackedProbe::misfit, probes) + kDamaged;
}

/// Sweeps in which nothing is broken.
std::vector<TrackedProbe> whole_ones(const std::vector<TrackedProbe>& probes) {
  const double most = most_misfit(probes);
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

/// Is it not captured where the others are, although the noise leaves no doubt? Then it has another gain.
bool is_elsewhere(const TrackedProbe& probe, double least_step) {
  const double gain = std::exp(probe.log_gain), lost = 1.0 - gain;
  const bool weak = lost > kElsewhere && lost > kLoopEstimatorCertain * gain * probe.gain_deviation;
  return weak && std::abs(probe.delay_frames) > least_step;
}

/// Is as much power captured as of the others, with another course? What sounds beside a probe adds at least
/// the share that is not explained, and a gain that falls takes away as much.
bool is_displaced(const TrackedProbe& probe, const std::vector<TrackedProbe>& probes) {
  if (probe.misfit <= most_misfit(probes)) return false;
  if (probe.chi_squared <= kNoNoise * usual(&TrackedProbe::chi_squared, probes)) return false;
  const double gain = std::exp(probe.log_gain - usual(&TrackedProbe::log_gain, probes));
  return std::abs(gain * gain / (1.0 - probe.misfit) - 1.0) < 0.5 * probe.misfit;
}

/// Are there no more than some knocks, of which a probe may be made as little as of noise, and in the other
/// probes nothing, or something at another place in every second one?
bool are_knocks(const LoopEstimate& loop) {
  if (loop.fit.misfit < kHum || loop.probes.empty()) return false;
  // Where frames are lost again and again, most probes are still probes.
  if (2 * loop.steps.size() >= loop.probes.size() && usual(&TrackedProbe::misfit, loop.probes) > kHum)
    return true;
  const auto louder = [](const TrackedProbe& a, const TrackedProbe& b) { return a.log_gain < b.log_gain; };
  const auto loudest = std::max_element(loop.probes.begin(), loop.probes.end(), louder);
  return loudest->log_gain > usual(&TrackedProbe::log_gain, loop.probes) + kKnock;
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

}  // namespace

std::vector<double> LoopEstimate::without_dc() const {
  auto all = samples;
  for (auto& sample : all) sample -= floor.mean;
  return all;
}

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
  loop.found = loop.found && !are_knocks(loop);
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

/// The noise where nothing of the probe sounds: the last half second of the silence before it; where that
/// behind it, or the ends of the pauses, are far quieter or all there is, those. If nothing was found at all,
/// everything.
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
  const auto shortest = frames(kLoopEstimatorShortestQuiet);
  // The last silence before the probes that is long enough.
  std::vector<double> before;
  for (std::size_t n = 0; n < all.size() && all[n].at <= bursts_.repeated.front().at; ++n) {
    const auto to = all[n].at + coarse.frames - frames(kAir);
    const auto from =
        n == 0 ? 0 : std::max<std::int64_t>(0, all[n - 1].end() + coarse.frames + frames(kRinging));
    if (to - from >= shortest) before = copy(std::max(from, to - frames(kLoopEstimatorQuiet)), to);
  }
  const auto end = all.back().end() + coarse.frames + frames(kRinging);
  std::vector<double> between;
  for (std::size_t n = 1; n < all.size(); ++n) {
    const auto pause = all[n].at - all[n - 1].end();
    const auto part = copy(all[n].at + coarse.frames - pause / 3, all[n].at + coarse.frames - frames(kAir));
    between.insert(between.end(), part.begin(), part.end());
  }
  // Something else may sound in one of them.
  std::optional<NoiseFloor> best;
  for (const auto& part : {before, copy(end, end + frames(kLoopEstimatorQuiet)), between}) {
    if (std::ssize(part) < shortest) continue;
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
  const auto shape = settings.profile ? PathShape::Kept : PathShape::Free;
  const auto start = windows.start_of(window, coarse.sign, reach(coarse));
  const auto fit = fit_path(window, start, shape);
  // Where the noise leaves one narrow band far clearer than all others, its oscillation may be taken for the
  // place.
  const auto other = windows.start_of(window, coarse.sign, reach(coarse), kClearest);
  if (other.delay_frames == start.delay_frames) return fit;
  const auto again = fit_path(window, other, shape);
  return again.chi_squared < fit.chi_squared ? again : fit;
}

/// The model where it fits: it has no noise.
Spectrum LoopEstimator::expected(const CapturedWindow& window, const PathFit& fit) const {
  return fit.misfit < kFits ? windows.expected(fit.model) : ProbeWindows::cleaned(window);
}

void LoopEstimator::fit(LoopEstimate& loop) {
  loop.mean = windows.mean(loop.samples, loop.at, loop.steady);
  const auto off = windows.start_of(loop.mean, loop.coarse.sign, reach(loop.coarse)).delay_frames;
  loop.at += static_cast<std::int64_t>(off);
  const bool by_probes = loop.coarse.clear() && loop.steady.size() >= kManyProbes;
  // Beside probes there may be another noise than in the pauses.
  if (by_probes) windows.set_noise_of(loop.samples, loop.at, loop.steady);
  if (off != 0.0 || by_probes) loop.mean = windows.mean(loop.samples, loop.at, loop.steady);
  loop.fit = fit_of(loop.mean, loop.coarse);
  estimate_noise(loop, by_probes);
  // A tone or a click may correlate with a probe, but no path makes one from the other.
  const double gain = loop.fit.model.log_gain;
  const bool nonsense = gain > kStrongest && loop.fit.misfit > kHum;
  loop.found = loop.fit.strength >= CoarseDelay::kNothing && gain >= kFaintest && !nonsense;
}

void LoopEstimator::estimate_noise(LoopEstimate& loop, bool by_probes) {
  loop.noise = loop.floor.variance;
  if (loop.steady.size() < 2) return;
  const auto variances = windows.scatter(loop.samples, loop.at, loop.steady, loop.mean);
  const auto [least, most] = std::minmax_element(variances.begin(), variances.end());
  loop.noise = std::max(loop.noise, median(variances));
  loop.unsteady = *most > kUnsteady * *least || loop.noise > kUnsteady * loop.floor.variance;
  if (!by_probes) return;
  std::vector<RepeatedWindow> bursts;
  for (const auto& probe : loop.steady)
    bursts.push_back({windows.one(loop.samples, loop.at, probe.burst),
                      probe.burst.gain * probe.burst.gain / total_power(loop.steady)});
  loop.error = DelayError::of(loop.mean, loop.fit, bursts);
}

void LoopEstimator::compare(LoopEstimate& loop) {
  loop.probes = windows.track(loop.bursts.repeated, loop.samples, loop.at, kLoopEstimatorSearch,
                              expected(loop.mean, loop.fit));
  const auto whole = whole_ones(loop.probes);
  loop.least_step = least_step(whole);
  loop.trend = DelayTrend::of(points_of(whole, loop.constant()), loop.least_step);
  loop.steps = loop.trend.steps;
  for (const auto& probe : loop.probes)
    if (is_elsewhere(probe, loop.least_step) || is_displaced(probe, loop.probes))
      loop.steps.push_back({probe.burst.at, 0.0});
  const bool describes =
      loop.fit.misfit < kFits;  // the path, so that what it makes of other signals is known
  // An actuator keeps too little of so short a sound.
  const bool is_cable = loop.fit.misfit < kCable && !settings.profile;
  if (const auto mark = loop.bursts.mark(rate); mark && is_cable) add_mark_steps(loop, *mark, whole);
  if (const auto pilot = loop.bursts.pilot(rate); pilot && describes) add_pilot_steps(loop, *pilot, whole);
  if (loop.steps.empty()) find_damage(loop);
}

SingleBurst LoopEstimator::single(const LoopEstimate& loop, const Burst& burst, std::int64_t at) const {
  return {recording.played, burst, loop.fit.model, profile, at};
}

/// Steps before the probes. Of one within a probe, which moves it by half, the others show all.
void LoopEstimator::add_mark_steps(LoopEstimate& loop, const Burst& mark,
                                   const std::vector<TrackedProbe>& whole) const {
  const auto at = loop.at + (loop.steps.empty() ? 0 : std::llround(whole.front().delay_frames));
  const auto silence = loop.bursts.repeated.front().at - mark.end();
  const auto track = track_mark(single(loop, mark, at), loop.without_dc(), silence);
  loop.ends_hidden = loop.fit.misfit < kFitsWell && track.recorded && !track.judged;
  loop.steps.insert(loop.steps.begin(), track.steps.begin(), track.steps.end());
}

/// Steps behind the probes, where the pilot sounds.
void LoopEstimator::add_pilot_steps(LoopEstimate& loop, const Burst& pilot,
                                    const std::vector<TrackedProbe>& whole) const {
  const auto burst = single(loop, pilot, loop.at);
  const auto track = track_pilot(burst, loop.without_dc(), loop.noise, loop.unsteady);
  std::vector<DelayPoint> points{points_of(whole, loop.constant()).back()};
  if (loop.steps.empty())
    points[0].delay_frames = loop.constant() + usual(&TrackedProbe::delay_frames, whole);
  points.insert(points.end(), track.points.begin(), track.points.end());
  const auto more = DelayTrend::of(points, std::max(loop.least_step, track.least_step)).steps;
  // What is louder than the pilot now and then is found at many places; frames are lost once.
  const bool is_loud = power(burst.expected(), 0.0) > kLoudPilot * loop.noise;
  if ((loop.unsteady || !is_loud) && more.size() > 1) {
    loop.ends_hidden = true;
    return;
  }
  loop.steps.insert(loop.steps.end(), more.begin(), more.end());
  if (loop.steps.empty() && loop.fit.misfit < kFitsWell && !settings.profile)
    for (const auto place : track.damage) loop.steps.push_back({place, 0.0});
}

void LoopEstimator::find_damage(LoopEstimate& loop) {
  std::vector<ProbeInTime> probes;
  for (const auto& probe : loop.probes)
    probes.push_back(windows.in_time(loop.samples, loop.at, probe, loop.mean));
  const auto longest = static_cast<std::int64_t>(frames_in(kLongestDamage, rate));
  const bool between = loop.bursts.mark(rate) && loop.bursts.pilot(rate);
  const auto damage = ProbeDamage::of(probes, loop.probes, loop.noise, longest, !between);
  loop.overdriven = damage.overdriven;
  loop.steps.insert(loop.steps.end(), damage.steps.begin(), damage.steps.end());
}

}  // namespace tactus
