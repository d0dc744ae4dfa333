#include "latency/estimation/analysis.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>
#include <string>

#include "engine/core/decibels.h"
#include "latency/estimation/loop_estimator.h"
#include "latency/findings.h"
#include "latency/path/response.h"
#include "latency/path/second_path.h"
#include "latency/probe/probe.h"

namespace tactus {
namespace {

constexpr double kAnalysisRounding =
    1e-4;  // misfit: less is left by the steps of converters, which have no shape
constexpr Seconds kThroughActuator{0.00002};  // standard error: five of them are a tenth of a millisecond

/// The gain of the bursts before the sweeps (the level ramp), for what changes with time.
std::optional<double> level_probe_gain_db(const LoopEstimator& path) {
  std::optional<double> highest;
  for (const auto& burst : path.bursts.others) {
    if (burst.at > path.bursts.repeated.front().at) continue;
    const auto played = stretch(path.recording.played, burst.at, burst.end());
    const auto heard = stretch(path.steady_heard, burst.at + path.at, burst.end() + path.at);
    if (heard.size() < played.size()) continue;
    double common = 0.0, loudness = 0.0;
    for (std::size_t n = 0; n < played.size(); ++n) {
      common += played[n] * (heard[n] - path.floor.mean);
      loudness += played[n] * played[n];
    }
    // Only what stands 20 dB out of the noise tells its gain within a decibel.
    if (common * common < 100.0 * loudness * path.floor.variance) continue;
    const double gain = power_to_db(common * common / (loudness * loudness));
    highest = std::max(highest.value_or(gain), gain);
  }
  return highest;
}

/// Without the profile, where the model was fitted.
double gain_range_db(const LoopEstimator& path) {
  double lowest = 1e300, highest = 0.0;
  const auto hertz = [&](std::size_t bin) {
    return static_cast<double>(bin) / static_cast<double>(path.mean.size) * path.rate().value;
  };
  const double stop = measuring_sweep(path.rate()).stop.value;
  for (auto b = path.mean.lowest_bin; hertz(b) < stop; ++b) {
    const double gain = std::norm(path.fitted.model.at(angular_frequency(b, path.mean.size)));
    lowest = std::min(lowest, gain);
    highest = std::max(highest, gain);
  }
  return power_to_db(highest / lowest);
}

/// How strong signal and noise are, and what nobody could do better with them.
void report_level(const LoopEstimator& path, Analysis& analysis) {
  const auto response = path.fitted.model.spectrum(path.mean.size, path.mean.profile);
  double heard_energy = 0.0, energy = 0.0, slope_energy = 0.0;  // of a burst of gain 1
  double played = 0.0, played_here = 0.0;
  const double per_bin = 2.0 / static_cast<double>(path.mean.size);
  for (std::size_t b = 1; b < response.size(); ++b) {
    heard_energy += per_bin * (std::norm(path.mean.heard[b]) - path.mean.noise[b]);
    played += std::norm(path.mean.played[b]);
    if (b < path.mean.lowest_bin) continue;
    const double w = angular_frequency(b, path.mean.size);
    const double expected = per_bin * std::norm(response[b] * path.mean.played[b]);
    played_here += std::norm(path.mean.played[b]);
    energy += expected;
    slope_energy += w * w * expected;
  }
  energy *= played / played_here;  // below the model's band as within
  analysis.bound_frames = std::sqrt(path.noise / (total_power(path.steady) * slope_energy));
  // Power that the model leaves over is phase that is wrong somewhere.
  if (path.fitted.misfit > kAnalysisRounding)
    analysis.misfit_frames = std::sqrt(0.5 * path.fitted.misfit * energy / slope_energy);
  analysis.snr_db =
      power_to_db(std::max(energy, heard_energy) / static_cast<double>(path.bursts.waveform.size())) -
      power_to_db(path.noise);
  analysis.gain_db = 20.0 / std::numbers::ln10 * path.fitted.model.log_gain;
}

void report_delay(const LoopEstimator& path, Analysis& analysis) {
  const double first = static_cast<double>(path.bursts.repeated.front().at);
  const double last = static_cast<double>(path.bursts.repeated.back().end());
  analysis.delay_frames = path.as_heard(path.constant(), 0.5 * (first + last));
  analysis.spread_frames = path.trend.scatter;
  const double by_scatter =
      path.trend.scatter /
      std::sqrt(static_cast<double>(std::max<std::size_t>(1, path.trend.longest.size())));
  // Noise that is there only while something sounds.
  const double more = path.floor.variance > 1e-16 ? std::max(1.0, path.noise / path.floor.variance) : 1.0;
  const double by_noise = path.fitted.delay_deviation * std::sqrt(std::max(1.0, path.fitted.chi_squared));
  analysis.standard_error_frames = std::max({by_scatter, by_noise * std::sqrt(more), analysis.misfit_frames});
  analysis.polarity = path.fitted.model.sign < 0.0 ? -1 : 1;
  analysis.misfit = path.fitted.misfit;
}

void report_sweeps(const LoopEstimator& path, Analysis& analysis) {
  analysis.drift_ppm = 1e6 * (path.speed * (1.0 + path.trend.slope) - 1.0);
  analysis.drift_standard_error_ppm = 1e6 * path.trend.slope_deviation;
  analysis.steps = path.steps;
  analysis.compared = path.sweeps.size() >= 3;
  for (const auto& sweep : path.sweeps)
    analysis.sweeps.push_back(
        {sweep.burst.at,
         path.as_heard(path.constant() + sweep.delay_frames, static_cast<double>(sweep.burst.at)),
         20.0 / std::numbers::ln10 * (path.fitted.model.log_gain + sweep.log_gain),
         sweep.burst.gain * path.bursts.peak});
}

/// Of the sweeps at full level alone: distortion depends on the level.
HeardWindow loud_mean(LoopEstimator& path) {
  std::vector<TrackedSweep> loud;
  for (const auto& sweep : path.steady)
    if (sweep.burst.gain > 0.75) loud.push_back(sweep);
  return path.windows.mean(path.steady_heard, path.at, loud.empty() ? path.steady : loud);
}

void report_details(LoopEstimator& path, const Response& response, Analysis& analysis) {
  const double shift = path.as_heard(static_cast<double>(path.at), 0.0);
  analysis.spectrum = response.spectrum();
  analysis.group_delay = response.group_delay(shift);
  int first = 0;
  analysis.response = response.impulse(first);
  analysis.response_at = path.at + first;
  const auto sweep = measuring_sweep(path.rate());
  if (repeats(path.bursts.waveform, sweep.samples(path.rate())))
    analysis.harmonics_db =
        harmonics(loud_mean(path), path.fitted.model, sweep, path.rate(), path.windows.fourier());
  const auto within = [&](const ResponsePoint& point) { return point.gain_db > analysis.gain_db - 3.0; };
  const auto& points = analysis.spectrum;
  if (const auto low = std::find_if(points.begin(), points.end(), within); low != points.end())
    analysis.low_hz = low->frequency_hz;
  if (const auto high = std::find_if(points.rbegin(), points.rend(), within); high != points.rend())
    analysis.high_hz = high->frequency_hz;
  analysis.high_pass_hz = std::max(
      0.0, -path.fitted.model.high_pass[0] * PathModel::kScale * path.rate().value / (2 * std::numbers::pi));
}

/// All of it, and what stands against trusting it.
void report(LoopEstimator& path, Analysis& analysis) {
  Evidence evidence;
  evidence.coarse = path.coarse;
  evidence.overdriven = path.overdriven;
  evidence.with_profile = path.settings.profile.has_value();
  if (evidence.with_profile) evidence.widest_error_frames = frames_in(kThroughActuator, path.rate());
  const Response response{path.mean, path.fitted.model, path.rate(), path.windows.fourier()};
  evidence.second = find_second_path(path);
  if (evidence.second)
    analysis.echo_frames = static_cast<int>(evidence.second->frames);
  else if (path.fitted.misfit > 1e-3)
    evidence.echo = response.echo();
  if (evidence.echo.frames != 0) analysis.echo_frames = evidence.echo.frames;
  evidence.level_probe_gain_db = level_probe_gain_db(path);
  evidence.gain_range_db = gain_range_db(path);
  report_sweeps(path, analysis);
  report_level(path, analysis);
  report_delay(path, analysis);
  if (path.settings.details) report_details(path, response, analysis);
  analysis.finding = judge(analysis, evidence, path.heard);
}

bool all_finite(const std::vector<double>& samples) {
  return std::all_of(samples.begin(), samples.end(), [](double sample) { return std::isfinite(sample); });
}

Status check(const LoopRecording& recording, const AnalysisSettings& settings) {
  if (settings.channel < 0 || settings.channel >= static_cast<int>(recording.heard.size()))
    return fail(Errc::BadArgument, "", "there is no input " + std::to_string(settings.channel + 1),
                "choose one from 1 to " + std::to_string(recording.heard.size()));
  const auto& heard = recording.heard[static_cast<std::size_t>(settings.channel)];
  if (heard.empty()) return fail(Errc::BadArgument, "", "nothing was recorded", "record at least one sweep");
  if (settings.profile && settings.profile->sample_rate != recording.sample_rate)
    return fail(Errc::BadArgument, "", "the profile was measured at another sample rate than this recording",
                "calibrate again at this rate");
  if (!all_finite(recording.played) || !all_finite(heard))
    return fail(Errc::BadArgument, "", "a sample is no number", "record it again");
  return {};
}

}  // namespace

Result<Analysis> analyze(const LoopRecording& recording, const AnalysisSettings& settings) {
  if (const auto possible = check(recording, settings); !possible) return tl::unexpected{possible.error()};
  auto bursts = find_bursts(recording.played, recording.sample_rate);
  if (!bursts) return fail(Errc::BadArgument, "", "nothing was played", "give the probe that was played");
  LoopEstimator path{recording, settings, std::move(*bursts)};
  Analysis analysis;
  analysis.sample_rate = recording.sample_rate;
  analysis.heard = path.find();
  analysis.dc = path.floor.mean;
  analysis.noise_floor_dbfs = power_to_db(path.floor.variance);
  if (analysis.heard) {
    path.follow_clock();
    analysis.heard = path.fit();
  }
  if (!analysis.heard) {
    analysis.finding = path.cut_short ? not_whole() : not_heard(path.every_channel(), settings.channel);
    return analysis;
  }
  if (path.coarse.clear()) path.compare_sweeps();
  report(path, analysis);
  return analysis;
}

}  // namespace tactus
