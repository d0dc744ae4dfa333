#include "latency/estimation/analysis.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>

#include "engine/core/decibels.h"
#include "engine/core/index.h"
#include "engine/core/median.h"
#include "latency/estimation/loop_estimator.h"
#include "latency/findings.h"
#include "latency/path/response.h"
#include "latency/probe/probe.h"

namespace tactus {
namespace {

constexpr double kAnalysisRounding =
    1e-4;                        // misfit: less is left by the steps of converters, which have no shape
constexpr double kFaint = 1e-6;  // of the probe's loudest frequency
constexpr Seconds kThroughActuator{0.00002};  // standard error: five of them are a tenth of a millisecond

/// The gain of the bursts before the probes (the level ramp), for what changes with time. The mark has more
/// treble than probes, so that its gain is not theirs.
std::optional<double> level_probe_gain_db(std::span<const double> all_played, const LoopEstimate& loop,
                                          Hertz rate) {
  const auto mark = loop.bursts.mark(rate);
  std::optional<double> highest;
  for (const auto& burst : loop.bursts.others) {
    if (burst.at > loop.bursts.repeated.front().at || (mark && burst.at == mark->at)) continue;
    const auto played = part_of(all_played, burst.at, burst.end());
    const auto captured = part_of(loop.samples, burst.at + loop.at, burst.end() + loop.at);
    if (captured.size() < played.size()) continue;
    double common = 0.0, loudness = 0.0;
    for (std::size_t n = 0; n < played.size(); ++n) {
      common += played[n] * (captured[n] - loop.floor.mean);
      loudness += played[n] * played[n];
    }
    // Only 20 dB above the noise the gain is known within a decibel.
    if (common * common < 100.0 * loudness * loop.floor.variance) continue;
    const double gain = power_to_db(common * common / (loudness * loudness));
    highest = std::max(highest.value_or(gain), gain);
  }
  return highest;
}

Hertz fitted_from(const LoopEstimate& loop, Hertz rate) {
  return Hertz{static_cast<double>(loop.mean.lowest_bin) * rate.value / static_cast<double>(loop.mean.size)};
}

/// Without the profile, where the model was fitted. A resampled probe ends before its own stop frequency
/// at the rate of the recording.
double gain_range_db(const LoopEstimate& loop, Hertz rate) {
  double lowest = 1e300, highest = 0.0, loudest = 0.0;
  for (const auto& bin : loop.mean.played) loudest = std::max(loudest, std::norm(bin));
  const auto hertz = [&](std::size_t bin) {
    return static_cast<double>(bin) / static_cast<double>(loop.mean.size) * rate.value;
  };
  const double stop = measuring_probe(rate).stop.value;
  for (auto b = loop.mean.lowest_bin; hertz(b) < stop; ++b) {
    if (std::norm(loop.mean.played[b]) < kFaint * loudest) continue;
    const double gain = std::norm(loop.fit.model.at(angular_frequency(b, loop.mean.size)));
    lowest = std::min(lowest, gain);
    highest = std::max(highest, gain);
  }
  return power_to_db(highest / lowest);
}

/// Levels of signal and noise, and the bound on the error that follows.
void report_level(const LoopEstimate& loop, Analysis& analysis) {
  const auto response = loop.fit.model.spectrum(loop.mean.size, loop.mean.profile);
  double captured_energy = 0.0, energy = 0.0, slope_energy = 0.0;  // of a burst of gain 1
  double played = 0.0, played_here = 0.0;
  const double per_bin = 2.0 / static_cast<double>(loop.mean.size);
  for (std::size_t b = 1; b < response.size(); ++b) {
    captured_energy += per_bin * (std::norm(loop.mean.captured[b]) - loop.mean.noise[b]);
    played += std::norm(loop.mean.played[b]);
    if (b < loop.mean.lowest_bin) continue;
    const double w = angular_frequency(b, loop.mean.size);
    const double expected = per_bin * std::norm(response[b] * loop.mean.played[b]);
    played_here += std::norm(loop.mean.played[b]);
    energy += expected;
    slope_energy += w * w * expected;
  }
  energy *= played / played_here;  // below the model's band as within
  analysis.bound_frames = std::sqrt(loop.noise / (total_power(loop.steady) * slope_energy));
  // Power that the model leaves over is phase that is wrong somewhere.
  if (loop.fit.misfit > kAnalysisRounding)
    analysis.misfit_frames = std::sqrt(0.5 * loop.fit.misfit * energy / slope_energy);
  analysis.snr_db =
      power_to_db(std::max(energy, captured_energy) / static_cast<double>(loop.bursts.waveform.size())) -
      power_to_db(loop.noise);
  analysis.gain_db = 20.0 / std::numbers::ln10 * loop.fit.model.log_gain;
}

void report_delay(const LoopEstimate& loop, Analysis& analysis) {
  const double first = static_cast<double>(loop.bursts.repeated.front().at);
  const double last = static_cast<double>(loop.bursts.repeated.back().end());
  analysis.delay_frames = loop.captured_delay(loop.constant(), 0.5 * (first + last));
  analysis.spread_frames = loop.trend.scatter;
  analysis.polarity = loop.fit.model.sign < 0.0 ? -1 : 1;
  analysis.misfit = loop.fit.misfit;
  if (loop.error) {
    const double by_probes = std::hypot(loop.error->noise_frames, loop.error->shape_frames);
    analysis.standard_error_frames = std::max(by_probes, analysis.misfit_frames);
    return;
  }
  const double by_scatter =
      loop.trend.scatter /
      std::sqrt(static_cast<double>(std::max<std::size_t>(1, loop.trend.longest.size())));
  // Noise that is there only while something sounds.
  const double more = loop.floor.variance > 1e-16 ? std::max(1.0, loop.noise / loop.floor.variance) : 1.0;
  const double by_noise = loop.fit.delay_deviation * std::sqrt(std::max(1.0, loop.fit.chi_squared));
  analysis.standard_error_frames = std::max({by_scatter, by_noise * std::sqrt(more), analysis.misfit_frames});
}

/// The scatter of few probes may be small by chance, but is not below what the noise makes.
double slope_deviation(const LoopEstimate& loop) {
  double weights = 0.0, times = 0.0, squares = 0.0;
  for (const auto& probe : loop.steady) {
    const double weight = probe.burst.gain * probe.burst.gain, time = static_cast<double>(probe.burst.at);
    weights += weight;
    times += weight * time;
    squares += weight * time * time;
  }
  const double around = squares / weights - (times / weights) * (times / weights);
  double noise = loop.error ? loop.error->noise_frames : 0.0;
  for (const auto& probe : loop.probes)
    noise = std::max(noise, probe.deviation_frames * probe.burst.gain / std::sqrt(weights));
  const double by_noise = around > 0.0 ? noise / std::sqrt(around) : 0.0;
  return std::max(loop.trend.slope_deviation, by_noise);
}

void report_probes(const LoopEstimate& loop, Analysis& analysis) {
  analysis.drift_ppm = 1e6 * (loop.speed * (1.0 + loop.trend.slope) - 1.0);
  analysis.drift_standard_error_ppm = 1e6 * slope_deviation(loop);
  analysis.steps = loop.steps;
  analysis.compared = loop.probes.size() >= 3;
  for (const auto& probe : loop.probes)
    analysis.probes.push_back(
        {probe.burst.at,
         loop.captured_delay(loop.constant() + probe.delay_frames, static_cast<double>(probe.burst.at)),
         20.0 / std::numbers::ln10 * (loop.fit.model.log_gain + probe.log_gain),
         probe.burst.gain * loop.bursts.peak, 20.0 / std::numbers::ln10 * probe.gain_deviation});
}

/// Of the probes at full level alone: distortion depends on the level.
std::vector<TrackedProbe> loud_ones(const LoopEstimate& loop) {
  std::vector<TrackedProbe> loud;
  for (const auto& probe : loop.steady)
    if (probe.burst.gain > 0.75) loud.push_back(probe);
  return loud.empty() ? loop.steady : loud;
}

std::array<std::optional<double>, 4> harmonics_of(LoopEstimator& estimator, const LoopEstimate& loop,
                                                  const ExponentialSweep& probe) {
  auto loud = loud_ones(loop);
  const auto mean = estimator.windows.mean(loop.samples, loop.at, loud);
  loud.resize(loud.size() / 2 * 2);
  for (std::size_t n = 1; n < loud.size(); n += 2) loud[n].burst.gain *= -1.0;
  Spectrum differences;
  if (!loud.empty()) differences = estimator.windows.mean(loop.samples, loop.at, loud).captured;
  return Response{mean, loop.fit.model, estimator.rate, estimator.windows.fourier()}.harmonics(probe,
                                                                                               differences);
}

/// Far above the corners f_k of one-pole high-passes their phase is sum f_k / f: `shape[0]`. The model's
/// series in S / f, S their sum, ends before its fourth power.
void report_high_pass(const LoopEstimate& loop, Hertz rate, Analysis& analysis) {
  const double unit_hz = PathModel::kScale * rate.value / (2 * std::numbers::pi);
  analysis.high_pass_hz = std::max(0.0, -loop.fit.model.shape[0] * unit_hz);
  analysis.fitted_from_hz = fitted_from(loop, rate).value;
  if (!loop.fit.high_pass_deviation) return;
  const double by_noise =
      *loop.fit.high_pass_deviation * std::sqrt(std::max(1.0, loop.fit.chi_squared)) * unit_hz;
  const double left_out =
      analysis.high_pass_hz * std::pow(analysis.high_pass_hz / analysis.fitted_from_hz, 4);
  analysis.high_pass_error_hz = std::hypot(by_noise, left_out);
}

void report_details(LoopEstimator& estimator, const LoopEstimate& loop, const Response& response,
                    Analysis& analysis) {
  const double shift = loop.captured_delay(static_cast<double>(loop.at), 0.0);
  analysis.spectrum = response.spectrum();
  analysis.group_delay = response.group_delay(shift);
  int first = 0;
  analysis.response = response.impulse(first);
  analysis.response_at = loop.at + first;
  const auto probe = measuring_probe(estimator.rate);
  if (repeats(loop.bursts.waveform, probe.samples(estimator.rate)))
    analysis.harmonics_db = harmonics_of(estimator, loop, probe);
  const auto within = [&](const ResponsePoint& point) { return point.gain_db > analysis.gain_db - 3.0; };
  const auto& points = analysis.spectrum;
  if (const auto low = std::find_if(points.begin(), points.end(), within); low != points.end())
    analysis.low_hz = low->frequency_hz;
  if (const auto high = std::find_if(points.rbegin(), points.rend(), within); high != points.rend())
    analysis.high_hz = high->frequency_hz;
  report_high_pass(loop, estimator.rate, analysis);
}

constexpr double kSoftest = 0.01;  // of the path: it moves no delay by a thousandth of a frame
constexpr double kAside = 2.0;
constexpr int kHighestOrder = 9;
constexpr double kBesideHarmonic = 3.0;  // frames

/// The share of the path's response to a burst that `rest` contains at the delay `frames`.
double usual_level(const LoopEstimate& loop, std::span<const double> first, std::span<const double> rest,
                   std::int64_t frames) {
  std::vector<double> levels;
  for (const auto& burst : loop.bursts.repeated) {
    const auto whole = part_of(first, burst.at + loop.at, burst.end() + loop.at);
    const auto again = part_of(rest, burst.at + frames, burst.end() + frames);
    const bool recorded = again.size() == whole.size();
    levels.push_back(recorded ? std::abs(product(again, whole)) / product(whole, whole) : 0.0);
  }
  return median(std::move(levels));
}

/// Searches what is left of the recording once the path is taken away, where the path is known. It has to be
/// captured of most probes: where frames are lost, some are captured at one delay and the others at another.
std::optional<SecondPath> find_second_path(const LoopEstimate& loop, Hertz rate, CoarseSearch& search) {
  if (!loop.coarse.clear()) return std::nullopt;
  auto model = loop.fit.model;
  model.delay_frames = loop.constant();
  const auto first = search.behind(model, fitted_from(loop, rate));
  auto rest = search.above(loop.samples, fitted_from(loop, rate));
  for (std::size_t n = 0; n < rest.size(); ++n) rest[n] -= first[n];
  if (product(rest, rest) < kSoftest * kSoftest * product(first, first)) return std::nullopt;

  const auto found = search.find(rest);
  SecondPath second;
  second.frames = found.frames - std::llround(loop.constant());
  if (!found.clear() || std::abs(second.frames) <= SecondPath::near(rate)) return std::nullopt;
  const double level = usual_level(loop, first, rest, found.frames);
  // A gain that moves leaves something at the path itself, which may look alike probes later.
  if (level < kSoftest || level < kAside * usual_level(loop, first, rest, loop.at)) return std::nullopt;
  second.level_db = amplitude_to_db(level);
  return second;
}

/// Of which order of distortion an exponential probe has the response so many frames from the linear one.
std::optional<int> harmonic_at(int frames, const LoopEstimate& loop, Hertz rate) {
  const auto probe = measuring_probe(rate);
  if (!repeats(loop.bursts.waveform, probe.samples(rate))) return std::nullopt;
  const double growth = frames_in(probe.growth(), rate);
  for (int order = 2; order <= kHighestOrder; ++order)
    if (std::abs(static_cast<double>(frames) + growth * std::log(order)) <= kBesideHarmonic) return order;
  return std::nullopt;
}

void report(LoopEstimator& estimator, const LoopEstimate& loop, Analysis& analysis) {
  Evidence evidence;
  evidence.coarse = loop.coarse;
  evidence.overdriven = loop.overdriven;
  evidence.unsteady = loop.unsteady;
  evidence.least_step_frames = loop.least_step;
  evidence.ends_hidden = loop.ends_hidden;
  evidence.with_profile = estimator.settings.profile.has_value();
  if (evidence.with_profile) evidence.widest_error_frames = frames_in(kThroughActuator, estimator.rate);
  const Response response{loop.mean, loop.fit.model, estimator.rate, estimator.windows.fourier()};
  evidence.second = find_second_path(loop, estimator.rate, estimator.search);
  if (evidence.second)
    analysis.echo_frames = static_cast<int>(evidence.second->frames);
  else if (loop.fit.misfit > 1e-3)
    evidence.echo = response.echo();
  if (evidence.echo.frames != 0) analysis.echo_frames = evidence.echo.frames;
  if (analysis.echo_frames) evidence.harmonic = harmonic_at(*analysis.echo_frames, loop, estimator.rate);
  if (evidence.harmonic) analysis.echo_frames.reset();
  evidence.level_probe_gain_db = level_probe_gain_db(estimator.recording.played, loop, estimator.rate);
  evidence.gain_range_db = gain_range_db(loop, estimator.rate);
  report_probes(loop, analysis);
  report_level(loop, analysis);
  report_delay(loop, analysis);
  if (estimator.settings.details) report_details(estimator, loop, response, analysis);
  analysis.finding = verdict_of(analysis, evidence, estimator.captured);
}

bool all_finite(const std::vector<double>& samples) {
  return std::all_of(samples.begin(), samples.end(), [](double sample) { return std::isfinite(sample); });
}

Status check(const LoopRecording& recording, const AnalysisSettings& settings) {
  if (settings.channel < 0 || settings.channel >= static_cast<int>(recording.captured.size()))
    return fail(Errc::BadArgument, "", "there is no input " + std::to_string(settings.channel + 1),
                "choose one from 1 to " + std::to_string(recording.captured.size()));
  const auto& captured = recording.captured[index(settings.channel)];
  if (captured.empty())
    return fail(Errc::BadArgument, "", "nothing was recorded", "record at least one probe");
  if (settings.profile && settings.profile->sample_rate != recording.sample_rate)
    return fail(Errc::BadArgument, "",
                "the profile was measured at a different sample rate than this recording",
                "calibrate again at this rate");
  if (!all_finite(recording.played) || !all_finite(captured))
    return fail(Errc::BadArgument, "", "a sample is non-finite", "record it again");
  return {};
}

}  // namespace

Result<Analysis> analyze(const LoopRecording& recording, const AnalysisSettings& settings) {
  if (const auto possible = check(recording, settings); !possible) return tl::unexpected{possible.error()};
  auto bursts = find_bursts(recording.played, recording.sample_rate);
  if (!bursts) return fail(Errc::BadArgument, "", "nothing was played", "give the probe that was played");
  LoopEstimator estimator{recording, settings, *bursts};
  const auto loop = estimator.estimate();
  Analysis analysis;
  analysis.sample_rate = recording.sample_rate;
  analysis.detected = loop.found;
  analysis.dc = loop.floor.mean;
  analysis.noise_floor_dbfs = power_to_db(loop.floor.variance);
  if (loop.found) {
    report(estimator, loop, analysis);
    return analysis;
  }
  std::vector<CoarseDelay> channels;
  for (const auto& channel : recording.captured) channels.push_back(estimator.search.find(channel));
  analysis.finding = not_detected(channels, settings.channel, loop.cut_short);
  return analysis;
}

}  // namespace tactus
