#include "latency/estimation/probe_windows.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <utility>

#include "engine/core/index.h"
#include "engine/core/median.h"
#include "latency/estimation/loop_recording.h"

namespace tactus {
namespace {

constexpr std::int64_t kProbeWindowsLead =
    64;                              // frames before the burst: a filter may answer before its delay
constexpr Seconds kMostPause{0.12};  // after it; a longer one would add only noise
constexpr std::int64_t kProbeWindowsReach = 8192;  // frames that may be lost at once and still be found
constexpr double kLowestOfProfile = 30.0;  // where an actuator's resonance may be all that is captured
constexpr double kLowestHz = 150.0;        // above the corners of coupling capacitors and above hum

/// Around each burst there are a quarter of a pause for the window's edge, and before it another for what
/// comes early.
std::int64_t quarter_pause(const PlayedBursts& bursts, Hertz sample_rate) {
  const auto pause = std::min<std::int64_t>(bursts.pause, std::llround(frames_in(kMostPause, sample_rate)));
  return std::max<std::int64_t>(0, pause - 2 * kProbeWindowsLead) / 4;
}

/// The least gain with which `played` explains `captured`, both as they stand.
double log_gain(const CapturedWindow& window, double sign) {
  double common = 0.0, power = 0.0;
  for (auto b = window.lowest_bin; b + 1 < window.captured.size(); ++b) {
    const auto expected = window.profile.empty() ? window.played[b] : window.played[b] * window.profile[b];
    common += sign * (window.captured[b] * std::conj(expected)).real() / window.noise[b];
    power += std::norm(expected) / window.noise[b];
  }
  return std::log(std::max(common / power, 1e-9));
}

constexpr std::size_t kNoiseWindow = 1024;

std::vector<double> welch(std::span<const double> quiet, double mean) {
  Fourier fourier{kNoiseWindow};
  std::vector<double> power(fourier.bins(), 0.0), part(kNoiseWindow);
  double window_power = 0.0;
  int parts = 0;
  for (std::size_t at = 0; at + kNoiseWindow <= quiet.size(); at += kNoiseWindow / 2, ++parts) {
    window_power = 0.0;
    for (std::size_t n = 0; n < kNoiseWindow; ++n) {
      const double hann =
          0.5 - 0.5 * std::cos(2 * std::numbers::pi * (static_cast<double>(n) + 0.5) / kNoiseWindow);
      part[n] = hann * (quiet[at + n] - mean);
      window_power += hann * hann;
    }
    const auto spectrum = fourier.forward(part);
    for (std::size_t b = 0; b < power.size(); ++b) power[b] += std::norm(spectrum[b]);
  }
  for (auto& each : power) each /= window_power * parts;
  return power;
}

/// Under a Hann window: of hum, whose periods do not fit, next to nothing remains.
double mean_beside_hum(std::span<const double> quiet) {
  double sum = 0.0, weights = 0.0;
  for (std::size_t n = 0; n < quiet.size(); ++n) {
    const double place = (static_cast<double>(n) + 0.5) / static_cast<double>(quiet.size());
    const double weight = 1.0 - std::cos(2.0 * std::numbers::pi * place);
    sum += weight * quiet[n];
    weights += weight;
  }
  return sum / weights;
}

}  // namespace

NoiseFloor NoiseFloor::of(std::span<const double> quiet) {
  NoiseFloor floor;
  floor.per_frame = {0.0, 0.0};
  if (quiet.empty()) return floor;
  const auto frames = static_cast<double>(quiet.size());
  floor.mean = mean_beside_hum(quiet);
  for (const double sample : quiet) floor.variance += (sample - floor.mean) * (sample - floor.mean) / frames;
  if (quiet.size() < 2 * kNoiseWindow)
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

double usual(double TrackedProbe::*of, const std::vector<TrackedProbe>& probes) {
  std::vector<double> all;
  for (const auto& probe : probes) all.push_back(probe.*of);
  return median(std::move(all));
}

double total_power(std::span<const TrackedProbe> probes) {
  double sum = 0.0;
  for (const auto& probe : probes) sum += probe.burst.gain * probe.burst.gain;
  return sum;
}

ProbeWindows::ProbeWindows(const PlayedBursts& bursts, Hertz sample_rate, std::span<const double> profile)
    : sample_rate_(sample_rate),
      lead_(kProbeWindowsLead + quarter_pause(bursts, sample_rate)),
      frames_(lead_ + static_cast<std::int64_t>(bursts.waveform.size()) +
              2 * quarter_pause(bursts, sample_rate)),
      fade_(index(frames_), 1.0),
      fourier_(index(frames_ + kProbeWindowsReach)),
      lowest_bin_(
          static_cast<std::size_t>(std::ceil((profile.empty() ? kLowestHz : kLowestOfProfile) /
                                             sample_rate.value * static_cast<double>(fourier_.size())))) {
  // A window with hard edges would spread hum over all frequencies.
  const auto edge = index(quarter_pause(bursts, sample_rate));
  for (std::size_t n = 0; n < edge; ++n) {
    const double raised =
        0.5 - 0.5 * std::cos(std::numbers::pi * (static_cast<double>(n) + 0.5) / static_cast<double>(edge));
    fade_[n] = fade_[fade_.size() - 1 - n] = raised;
  }
  fade_power_ = std::inner_product(fade_.begin(), fade_.end(), fade_.begin(), 0.0);
  std::vector<double> placed(index(lead_), 0.0);
  placed.insert(placed.end(), bursts.waveform.begin(), bursts.waveform.end());
  played_ = fourier_.forward(placed);
  if (!profile.empty()) profile_ = fourier_.forward(profile);
}

void ProbeWindows::set_noise(const NoiseFloor& floor) {
  mean_ = floor.mean;
  noise_ = floor.in_bins(fourier_.size(), fade_power_);
  least_noise_ = *std::min_element(noise_.begin(), noise_.end());
}

void ProbeWindows::set_noise_of(std::span<const double> captured, std::int64_t frames,
                                std::span<const TrackedProbe> which) {
  double loudest = 0.0;
  for (const auto& probe : which) loudest = std::max(loudest, probe.burst.gain);
  std::vector<Spectrum> bursts;
  Spectrum mean(fourier_.bins());
  for (const auto& probe : which) {
    if (probe.burst.gain < 0.75 * loudest) continue;
    bursts.push_back(cut(captured, probe.burst.at + frames));
    for (std::size_t b = 0; b < mean.size(); ++b) mean[b] += bursts.back()[b];
  }
  if (bursts.size() < 2) return;
  const auto count = static_cast<double>(bursts.size());
  for (auto& bin : mean) bin /= count;
  Spectrum left(fourier_.bins());  // its power is that of the noise
  for (const auto& burst : bursts) {
    double common = 0.0, power = 0.0;
    for (auto b = lowest_bin_; b < mean.size(); ++b) {
      common += (burst[b] * std::conj(mean[b])).real() / noise_[b];
      power += std::norm(mean[b]) / noise_[b];
    }
    const double gain = power > 0.0 ? common / power : 1.0;
    for (std::size_t b = 0; b < mean.size(); ++b)
      left[b] += std::norm(burst[b] - gain * mean[b]) / (count - 1.0);
  }
  for (auto& bin : left) bin = std::sqrt(bin);
  noise_ = smoothed_power(left);
  for (auto& each : noise_) each = std::max(each, least_noise_);
}

Spectrum ProbeWindows::one(std::span<const double> captured, std::int64_t frames, const Burst& burst) {
  auto spectrum = cut(captured, burst.at + frames);
  for (auto& bin : spectrum) bin /= burst.gain;
  return spectrum;
}

Spectrum ProbeWindows::cut(std::span<const double> captured, std::int64_t from) {
  std::vector<double> samples(index(frames_), 0.0);
  const auto begin = from - lead_;
  const auto end = std::min(frames_, static_cast<std::int64_t>(captured.size()) - begin);
  for (auto n = std::max<std::int64_t>(-begin, 0); n < end; ++n) {
    const auto at = index(n);
    samples[at] = fade_[at] * (captured[index(begin + n)] - mean_);
  }
  return fourier_.forward(samples);
}

CapturedWindow ProbeWindows::window_of(Spectrum captured, double gain) const {
  CapturedWindow window{fourier_.size(), played_, std::move(captured), noise_, profile_, lowest_bin_};
  for (auto& bin : window.captured) bin /= gain;
  for (auto& bin : window.noise) bin /= gain * gain;
  return window;
}

std::int64_t ProbeWindows::nearest(const CapturedWindow& window, const Spectrum& expected,
                                   std::int64_t search, double clearest) {
  Spectrum cross(window.captured.size());
  for (auto b = window.lowest_bin; b + 1 < cross.size(); ++b)
    cross[b] = window.captured[b] * std::conj(expected[b]) /
               (window.noise[b] + clearest * std::norm(window.captured[b]));
  const auto correlation = fourier_.inverse(cross);
  const auto size = static_cast<std::int64_t>(correlation.size());
  std::int64_t best = 0;
  double highest = 0.0;
  for (auto lag = -search; lag <= search; ++lag)
    if (const double value = correlation[index((lag + size) % size)]; value > highest) {
      highest = value;
      best = lag;
    }
  return best;
}

std::vector<TrackedProbe> ProbeWindows::track(std::span<const Burst> bursts, std::span<const double> captured,
                                              std::int64_t near, std::int64_t search,
                                              const Spectrum& expected) {
  std::vector<TrackedProbe> tracked;
  for (const auto& burst : bursts) {
    auto window = window_of(cut(captured, burst.at + near), burst.gain);
    const auto later = nearest(window, expected, std::min(search, kProbeWindowsReach), 0.0);
    if (later != 0) window = window_of(cut(captured, burst.at + near + later), burst.gain);
    window.played = expected;
    window.profile.clear();
    PathModel start;
    start.log_gain = log_gain(window, 1.0);
    const auto fit = fit_path(window, start, PathShape::Kept);
    tracked.push_back({burst, static_cast<double>(later) + fit.model.delay_frames,
                       fit.delay_deviation * std::sqrt(std::max(1.0, fit.chi_squared)), fit.model.log_gain,
                       fit.gain_deviation * std::sqrt(std::max(1.0, fit.chi_squared)), fit.misfit,
                       fit.chi_squared});
  }
  return tracked;
}

Spectrum ProbeWindows::expected(const PathModel& model) const {
  auto all = model.spectrum(fourier_.size(), profile_);
  for (std::size_t b = 0; b < all.size(); ++b) all[b] *= played_[b];
  return all;
}

Spectrum ProbeWindows::cleaned(const CapturedWindow& window) {
  auto all = window.captured;
  const auto power = smoothed_power(all);
  for (std::size_t b = 0; b < all.size(); ++b)
    all[b] *= std::max(0.0, 1.0 - window.noise[b] / std::max(power[b], window.noise[b]));
  return all;
}

PathModel ProbeWindows::start_of(const CapturedWindow& window, double sign, std::int64_t search,
                                 double clearest) {
  PathModel start;
  start.sign = sign;
  start.delay_frames = static_cast<double>(nearest(window, expected(start), search, clearest));
  auto moved = window;
  moved.played = expected(start);
  moved.profile.clear();
  start.log_gain = log_gain(moved, 1.0);
  return start;
}

CapturedWindow ProbeWindows::mean(std::span<const double> captured, std::int64_t frames,
                                  std::span<const TrackedProbe> which) {
  Spectrum sum(fourier_.bins());
  for (const auto& probe : which) {
    const auto one = cut(captured, probe.burst.at + frames);
    for (std::size_t b = 0; b < sum.size(); ++b) sum[b] += probe.burst.gain * one[b];
  }
  const double weight = total_power(which);
  for (auto& bin : sum) bin /= std::sqrt(weight);
  return window_of(std::move(sum), std::sqrt(weight));
}

std::vector<double> ProbeWindows::scatter(std::span<const double> captured, std::int64_t frames,
                                          std::span<const TrackedProbe> which, const CapturedWindow& mean) {
  const double weight = total_power(which);
  const double share = 1.0 - 2.0 * static_cast<double>(lowest_bin_) / static_cast<double>(fourier_.size());
  std::vector<double> variances;
  for (const auto& probe : which) {
    const double gain = probe.burst.gain;
    const auto one = cut(captured, probe.burst.at + frames);
    double power = 0.0;
    for (auto b = lowest_bin_; b + 1 < one.size(); ++b)
      power += 2.0 * std::norm(one[b] - gain * mean.captured[b]);
    variances.push_back(power / (1.0 - gain * gain / weight) / static_cast<double>(fourier_.size()) /
                        fade_power_ / share);
  }
  return variances;
}

ProbeInTime ProbeWindows::in_time(std::span<const double> captured, std::int64_t frames,
                                  const TrackedProbe& probe, const CapturedWindow& mean) {
  auto here = one(captured, frames, probe.burst);
  auto all = mean.captured;
  const double gain = std::exp(probe.log_gain);
  for (std::size_t b = 0; b < here.size(); ++b) {
    all[b] *= b < lowest_bin_ ? 0.0 : gain;
    if (b < lowest_bin_) here[b] = 0.0;
  }
  return {probe.burst.at - lead_, fourier_.inverse(here), fourier_.inverse(all)};
}

}  // namespace tactus
