#include "latency/analysis.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>
#include <string>

#include "latency/bursts.h"
#include "latency/coarse.h"
#include "latency/delay_trend.h"
#include "latency/findings.h"
#include "latency/noise_floor.h"
#include "latency/pilot_track.h"
#include "latency/probe.h"
#include "latency/response.h"
#include "latency/sweep_windows.h"

namespace tactus {
namespace {

constexpr Seconds kQuiet{0.5};  // as much silence as is listened to
constexpr Seconds kAir{0.005};  // before the first burst is heard
constexpr std::int64_t kSearch = 8192;
constexpr double kLeastStep = 0.75;           // frames
constexpr double kCertain = 6.0;              // standard deviations
constexpr double kSilence = 1e-10;            // of the heard power: noise below -100 dB is no help to anybody
constexpr Seconds kThroughActuator{0.00002};  // standard error: five of them are a tenth of a millisecond
constexpr double kFaintest = -14.0;           // log gain: -122 dB, where no converter hears anything
constexpr double kNothing = 1e-18;            // -180 dBFS, below what a float sample of full scale can hold
constexpr double kDamaged = 0.05;             // of a sweep's power, more than other sweeps leave unexplained
constexpr double kFits = 0.02;                // misfit of a path that the model describes
constexpr int kDriftRounds = 3;

double decibels(double power) { return 10.0 * std::log10(std::max(power, 1e-30)); }

std::span<const double> clipped(std::span<const double> all, std::int64_t from, std::int64_t to) {
  const auto size = static_cast<std::int64_t>(all.size());
  from = std::clamp<std::int64_t>(from, 0, size);
  to = std::clamp<std::int64_t>(to, from, size);
  return all.subspan(static_cast<std::size_t>(from), static_cast<std::size_t>(to - from));
}

double power(std::span<const double> samples, double mean) {
  double sum = 0.0;
  for (const double sample : samples) sum += (sample - mean) * (sample - mean);
  return samples.empty() ? 0.0 : sum / static_cast<double>(samples.size());
}

/// Sweeps in which nothing is broken: those that leave about as much unexplained as the others.
std::vector<TrackedSweep> whole_ones(const std::vector<TrackedSweep>& sweeps) {
  std::vector<double> misfits;
  for (const auto& sweep : sweeps) misfits.push_back(sweep.misfit);
  const auto middle = misfits.begin() + static_cast<std::ptrdiff_t>(misfits.size() / 2);
  std::nth_element(misfits.begin(), middle, misfits.end());
  std::vector<TrackedSweep> whole;
  for (const auto& sweep : sweeps)
    if (sweep.misfit <= *middle + kDamaged) whole.push_back(sweep);
  return whole;
}

/// What can be told from noise; but half a frame of noise is not a lost frame.
double least_step(const std::vector<TrackedSweep>& sweeps) {
  double widest = 0.0;
  for (const auto& sweep : sweeps) widest = std::max(widest, sweep.deviation_frames);
  return std::max(kLeastStep, kCertain * widest);
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

class Analyst {
 public:
  Analyst(const LoopRecording& recording, const AnalysisSettings& settings, PlayedBursts bursts)
      : recording_(recording),
        settings_(settings),
        bursts_(std::move(bursts)),
        heard_(recording.heard[static_cast<std::size_t>(settings.channel)]),
        search_(through(recording.played, profile_taps()), heard_.size(), recording.sample_rate),
        windows_(bursts_, recording.sample_rate, profile_taps()) {
    analysis_.sample_rate = recording.sample_rate;
    if (settings.profile) evidence_.widest_error_frames = frames_in(kThroughActuator, recording.sample_rate);
  }

  Analysis run() {
    evidence_.coarse = search_.find(heard_);
    analysis_.heard = evidence_.coarse.found();
    listen_to_quiet();
    if (!analysis_.heard) return not_found();
    follow_clock();
    fit();
    // A tone or a click may correlate with a sweep, but no path makes one from the other.
    if (fit_.strength < CoarseDelay::kNothing || fit_.model.log_gain < kFaintest) return not_found();
    compare();
    describe();
    analysis_.finding = judge(analysis_, evidence_, heard_);
    return std::move(analysis_);
  }

 private:
  std::span<const double> profile_taps() const {
    return settings_.profile ? std::span<const double>{settings_.profile->taps} : std::span<const double>{};
  }
  Hertz rate() const { return recording_.sample_rate; }

  Analysis not_found() {
    analysis_.heard = false;
    analysis_.drift_ppm = analysis_.drift_standard_error_ppm = 0.0;
    for (const auto& channel : recording_.heard) evidence_.other_channels.push_back(search_.find(channel));
    analysis_.finding = not_heard(evidence_, settings_.channel);
    return std::move(analysis_);
  }

  /// The last half second before the first burst is heard; all of it, if none is.
  void listen_to_quiet() {
    std::span<const double> quiet = heard_;
    if (analysis_.heard) {
      auto first = bursts_.repeated.front().at;
      if (!bursts_.others.empty()) first = std::min(first, bursts_.others.front().at);
      const auto end = first + evidence_.coarse.frames - static_cast<std::int64_t>(frames_in(kAir, rate()));
      quiet = clipped(heard_, end - static_cast<std::int64_t>(frames_in(kQuiet, rate())), end);
    }
    floor_ = NoiseFloor::of(quiet);
    analysis_.dc = floor_.mean;
    analysis_.noise_floor_dbfs = decibels(floor_.variance);
    const auto from = bursts_.repeated.front().at + evidence_.coarse.frames;
    const double signal = power(clipped(heard_, from, from + bursts_.repeated.front().frames), floor_.mean);
    for (auto& each : floor_.per_frame) each = std::max(each, kSilence * signal + kNothing);
    windows_.set_noise(floor_);
  }

  /// Finds the drift between the clocks, and takes it off what was heard. The sweeps are compared with the
  /// loudest of them, so that it does not matter what the path makes of a sweep.
  void follow_clock() {
    steady_heard_ = heard_;
    for (const auto& burst : bursts_.repeated) steady_.push_back({.burst = burst});
    at_ = evidence_.coarse.frames;
    for (int round = 0; evidence_.coarse.clear() && round <= kDriftRounds; ++round) {
      sweeps_ = windows_.track(steady_heard_, at_, kSearch, loudest_sweep());
      const auto whole = whole_ones(sweeps_);
      const auto trend = DelayTrend::of(points_of(whole, 0.0), least_step(whole));
      steady_.clear();
      for (const auto n : trend.longest) steady_.push_back(whole[n]);
      const double length = static_cast<double>(whole.back().burst.end() - whole.front().burst.at);
      if (whole.size() < 3 || std::abs(trend.slope) * length < 1e-3 ||
          std::abs(trend.slope) < 3.0 * trend.slope_deviation)
        break;
      speed_ *= 1.0 + trend.slope;
      steadied_ = at_speed(heard_, speed_);
      steady_heard_ = steadied_;
    }
    at_ += std::llround(middle_delay());
  }

  Spectrum loudest_sweep() {
    const auto loudest = std::max_element(bursts_.repeated.begin(), bursts_.repeated.end(),
                                          [](const Burst& a, const Burst& b) { return a.gain < b.gain; });
    const TrackedSweep sweep{.burst = *loudest};
    const auto window = windows_.mean(steady_heard_, at_, {&sweep, 1});
    return expected(window, fitted(window));
  }

  PathFit fitted(const HeardWindow& window) {
    // What a profile knows is not to be guessed again.
    return fit_path(window,
                    windows_.start_of(window, evidence_.coarse.sign, evidence_.coarse.clear() ? kSearch : 0),
                    settings_.profile ? PathShape::Kept : PathShape::Free);
  }

  /// The model where it fits: it has no noise.
  Spectrum expected(const HeardWindow& window, const PathFit& fit) const {
    return fit.misfit < kFits ? windows_.expected(fit.model) : SweepWindows::cleaned(window);
  }

  /// The delay of what was played at `frame`, when it is `constant` once the drift is taken off.
  double as_heard(double constant, double frame) const { return (frame + constant) * speed_ - frame; }

  void fit() {
    mean_ = windows_.mean(steady_heard_, at_, steady_);
    const auto off =
        windows_.start_of(mean_, evidence_.coarse.sign, evidence_.coarse.clear() ? kSearch : 0).delay_frames;
    at_ += static_cast<std::int64_t>(off);
    if (off != 0.0) mean_ = windows_.mean(steady_heard_, at_, steady_);
    fit_ = fitted(mean_);
  }

  void compare() {
    noise_ = floor_.variance;
    if (steady_.size() > 1) noise_ = std::max(noise_, windows_.scatter(steady_heard_, at_, steady_, mean_));
    if (evidence_.coarse.clear()) compare_sweeps();
    report_delay();
  }

  double middle_delay() const {
    std::vector<double> delays;
    for (const auto& sweep : steady_) delays.push_back(sweep.delay_frames);
    const auto middle = delays.begin() + static_cast<std::ptrdiff_t>(delays.size() / 2);
    std::nth_element(delays.begin(), middle, delays.end());
    return *middle;
  }

  /// Each sweep again, now that the path is known.
  void compare_sweeps() {
    sweeps_ = windows_.track(steady_heard_, at_, kSearch, expected(mean_, fit_));
    const auto whole = whole_ones(sweeps_);
    trend_ = DelayTrend::of(points_of(whole, constant()), least_step(whole));
    analysis_.drift_ppm = 1e6 * (speed_ * (1.0 + trend_.slope) - 1.0);
    analysis_.drift_standard_error_ppm = 1e6 * trend_.slope_deviation;
    for (const auto& sweep : sweeps_)
      analysis_.sweeps.push_back(
          {sweep.burst.at, as_heard(constant() + sweep.delay_frames, static_cast<double>(sweep.burst.at)),
           20.0 / std::numbers::ln10 * (fit_.model.log_gain + sweep.log_gain),
           sweep.burst.gain * bursts_.peak});
    find_steps(whole);
  }

  /// The delay once the drift is taken off.
  double constant() const { return static_cast<double>(at_) + fit_.model.delay_frames; }

  void report_delay() {
    const double first = static_cast<double>(bursts_.repeated.front().at);
    const double last = static_cast<double>(bursts_.repeated.back().end());
    analysis_.delay_frames = as_heard(constant(), 0.5 * (first + last));
    analysis_.spread_frames = trend_.scatter;
    const double by_scatter =
        trend_.scatter / std::sqrt(static_cast<double>(std::max<std::size_t>(1, trend_.longest.size())));
    const double by_noise = fit_.delay_deviation * std::sqrt(std::max(1.0, fit_.chi_squared));
    analysis_.standard_error_frames = std::max(by_scatter, by_noise);
    analysis_.polarity = fit_.model.sign < 0.0 ? -1 : 1;
    analysis_.misfit = fit_.misfit;
  }

  /// Sweeps and, behind them, the pilot in pieces.
  void find_steps(const std::vector<TrackedSweep>& whole) {
    auto points = points_of(whole, constant());
    const auto pilot = bursts_.pilot(rate());
    if (pilot && fit_.misfit < kFits) {
      const auto more =
          track_pilot(recording_.played, steady_heard_, *pilot, at_, fit_.model, profile_taps());
      points.insert(points.end(), more.begin(), more.end());
    }
    analysis_.steps = DelayTrend::of(points, least_step(whole)).steps;
    if (!analysis_.steps.empty()) return;
    for (const auto& sweep : sweeps_)
      for (const auto place : windows_.damage(steady_heard_, at_, sweep, mean_, noise_))
        analysis_.steps.push_back({place, 0.0});
  }

  /// The gain of the bursts before the sweeps (the level ramp), for what changes with time.
  void look_at_knocks() {
    for (const auto& burst : bursts_.others) {
      if (burst.at > bursts_.repeated.front().at) continue;
      const auto played = clipped(recording_.played, burst.at, burst.end());
      const auto heard = clipped(steady_heard_, burst.at + at_, burst.end() + at_);
      if (heard.size() < played.size()) continue;
      double common = 0.0, loudness = 0.0;
      for (std::size_t n = 0; n < played.size(); ++n) {
        common += played[n] * (heard[n] - floor_.mean);
        loudness += played[n] * played[n];
      }
      // Only what stands 20 dB out of the noise tells its gain within a decibel.
      if (common * common < 100.0 * loudness * floor_.variance) continue;
      const double gain = decibels(common * common / (loudness * loudness));
      evidence_.knock_gain_db = std::max(evidence_.knock_gain_db.value_or(gain), gain);
    }
  }

  void describe() {
    const Response response{mean_, fit_.model, rate(), windows_.fourier()};
    evidence_.echo = fit_.misfit > 1e-3 ? response.echo() : Response::Echo{};
    if (evidence_.echo.frames != 0) analysis_.echo_frames = evidence_.echo.frames;
    look_at_knocks();
    report_level();
    if (settings_.details) report_details(response);
  }

  /// How strong signal and noise are, and what nobody could do better with them.
  void report_level() {
    const auto path = fit_.model.spectrum(mean_.size, mean_.profile);
    double heard_energy = 0.0, energy = 0.0, slope_energy = 0.0;  // of a burst of gain 1
    double played = 0.0, played_here = 0.0;
    const double per_bin = 2.0 / static_cast<double>(mean_.size);
    for (std::size_t b = 1; b < path.size(); ++b) {
      heard_energy += per_bin * (std::norm(mean_.heard[b]) - mean_.noise[b]);
      played += std::norm(mean_.played[b]);
      if (b < mean_.lowest_bin) continue;
      const double w = 2 * std::numbers::pi * static_cast<double>(b) / static_cast<double>(mean_.size);
      const double expected = per_bin * std::norm(path[b] * mean_.played[b]);
      played_here += std::norm(mean_.played[b]);
      energy += expected;
      slope_energy += w * w * expected;
    }
    energy *= played / played_here;  // below the model's band as within
    evidence_.gain_range_db = gain_range_db();
    double weight = 0.0;
    for (const auto& sweep : steady_) weight += sweep.burst.gain * sweep.burst.gain;
    analysis_.bound_frames = std::sqrt(noise_ / (weight * slope_energy));
    analysis_.snr_db =
        decibels(std::max(energy, heard_energy) / static_cast<double>(bursts_.waveform.size())) -
        decibels(noise_);
    analysis_.gain_db = 20.0 / std::numbers::ln10 * fit_.model.log_gain;
  }

  /// Without the profile, where the model was fitted.
  double gain_range_db() const {
    double lowest = 1e300, highest = 0.0;
    for (auto b = mean_.lowest_bin; hertz(b) < measuring_sweep(rate()).stop.value; ++b) {
      const double gain = std::norm(
          fit_.model.at(2 * std::numbers::pi * static_cast<double>(b) / static_cast<double>(mean_.size)));
      lowest = std::min(lowest, gain);
      highest = std::max(highest, gain);
    }
    return decibels(highest / lowest);
  }
  double hertz(std::size_t bin) const {
    return static_cast<double>(bin) / static_cast<double>(mean_.size) * rate().value;
  }

  void report_details(const Response& response) {
    const double shift = as_heard(static_cast<double>(at_), 0.0);
    analysis_.spectrum = response.spectrum();
    analysis_.group_delay = response.group_delay(shift);
    int first = 0;
    analysis_.response = response.impulse(first);
    analysis_.response_at = at_ + first;
    const auto sweep = measuring_sweep(rate());
    if (repeats(bursts_.waveform, sweep.samples(rate())))
      analysis_.harmonics_db = harmonics(loud_mean(), fit_.model, sweep, rate(), windows_.fourier());
    const auto within = [&](const ResponsePoint& point) { return point.gain_db > analysis_.gain_db - 3.0; };
    const auto& points = analysis_.spectrum;
    if (const auto low = std::find_if(points.begin(), points.end(), within); low != points.end())
      analysis_.low_hz = low->frequency_hz;
    if (const auto high = std::find_if(points.rbegin(), points.rend(), within); high != points.rend())
      analysis_.high_hz = high->frequency_hz;
    analysis_.high_pass_hz =
        std::max(0.0, -fit_.model.high_pass[0] * PathModel::kScale * rate().value / (2 * std::numbers::pi));
  }

  /// Of the sweeps at full level alone: distortion depends on the level.
  HeardWindow loud_mean() {
    std::vector<TrackedSweep> loud;
    for (const auto& sweep : steady_)
      if (sweep.burst.gain > 0.75) loud.push_back(sweep);
    return windows_.mean(steady_heard_, at_, loud.empty() ? steady_ : loud);
  }

  const LoopRecording& recording_;
  const AnalysisSettings& settings_;
  PlayedBursts bursts_;
  std::span<const double> heard_;
  CoarseSearch search_;
  SweepWindows windows_;
  NoiseFloor floor_;
  Analysis analysis_;
  Evidence evidence_;
  double speed_ = 1.0;
  double noise_ = 0.0;  ///< variance
  std::vector<double> steadied_;
  std::span<const double> steady_heard_;
  std::vector<TrackedSweep> sweeps_, steady_;
  std::int64_t at_ = 0;
  HeardWindow mean_;
  PathFit fit_;
  DelayTrend trend_;
};

}  // namespace

Result<Analysis> analyze(const LoopRecording& recording, const AnalysisSettings& settings) {
  if (settings.channel < 0 || settings.channel >= static_cast<int>(recording.heard.size()))
    return fail(Errc::BadArgument, "", "there is no input " + std::to_string(settings.channel + 1),
                "choose one from 1 to " + std::to_string(recording.heard.size()));
  const auto& heard = recording.heard[static_cast<std::size_t>(settings.channel)];
  if (heard.empty()) return fail(Errc::BadArgument, "", "nothing was recorded", "record at least one sweep");
  if (settings.profile && settings.profile->sample_rate != recording.sample_rate)
    return fail(Errc::BadArgument, "", "the profile was measured at another sample rate than this recording",
                "calibrate again at this rate");
  auto bursts = find_bursts(recording.played, recording.sample_rate);
  if (!bursts) return fail(Errc::BadArgument, "", "nothing was played", "give the probe that was played");
  return Analyst{recording, settings, std::move(*bursts)}.run();
}

}  // namespace tactus
