#include "latency/calibration.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "engine/core/decibels.h"
#include "engine/core/index.h"
#include "latency/estimation/probe_windows.h"
#include "latency/path/response.h"
#include "latency/probe/probe.h"

namespace tactus {
namespace {

constexpr double kLeastSnr = 20.0;        // dB
constexpr double kMaxUnexplained = 0.05;  // unexplained share that a profile may leave
constexpr double kTail = 1e-7;            // of the energy, that is cut off at the end of the taps
constexpr double kFlattest = 1e-5;        // of the probe's power: where nothing was played nothing is guessed
constexpr double kQuietest = 1e-18;       // variance: -180 dBFS
constexpr double kFirstSwing = 1.0 / 3;   // of the highest

/// The card's whole frames are taken off by cutting later, the rest by turning the phase.
CapturedWindow without_delay(ProbeWindows& windows, std::span<const double> captured, double delay,
                             std::span<const TrackedProbe> probes) {
  const double whole = std::floor(delay);
  auto window = windows.mean(captured, static_cast<std::int64_t>(whole), probes);
  for (std::size_t b = 0; b < window.captured.size(); ++b)
    window.captured[b] *= std::polar(1.0, angular_frequency(b, window.size) * (delay - whole));
  return window;
}

std::vector<double> taps_of(const CapturedWindow& window, Fourier& fourier, std::size_t length,
                            double noise) {
  Spectrum own(window.played.size()), common(window.played.size());
  double captured_power = 0.0, played_power = 0.0;
  for (std::size_t b = 0; b < own.size(); ++b) {
    own[b] = std::norm(window.played[b]);
    common[b] = window.captured[b] * std::conj(window.played[b]);
    captured_power += std::norm(window.captured[b]);
    played_power += own[b].real();
  }
  auto r = fourier.inverse(own), c = fourier.inverse(common);
  length = std::min(length, c.size() / 2);
  // Wiener: the variance of the noise over that of a tap, both as far as they are known.
  const double of_tap = captured_power / played_power / static_cast<double>(length);
  r[0] += std::max(noise / of_tap, kFlattest * r[0]);
  auto taps = solve_toeplitz(std::span{r}.first(length), std::span{c}.first(length));
  const double all = product(taps, taps);
  for (double tail = 0.0; taps.size() > 1; taps.pop_back())
    if ((tail += taps.back() * taps.back()) > kTail * all) break;
  return taps;
}

/// The share of what was captured, where it was played, that the taps leave over beyond the noise.
double unexplained(const CapturedWindow& window, const Spectrum& path) {
  double left = 0.0, captured = 0.0;
  for (auto b = window.lowest_bin; b + 1 < path.size(); ++b) {
    left += std::norm(window.captured[b] - path[b] * window.played[b]) - window.noise[b];
    captured += std::norm(window.captured[b]);
  }
  return std::max(0.0, left / captured);
}

/// Where |H| crosses 1 / sqrt(2) of its peak, walking from it by `step`; nothing if it never does.
std::optional<double> half_power(const std::vector<double>& power, std::size_t peak, int step) {
  for (auto b = static_cast<std::ptrdiff_t>(peak); b > 0 && b + 1 < static_cast<std::ptrdiff_t>(power.size());
       b += step) {
    const double current = power[index(b)], next = power[index(b + step)];
    if (next > 0.5 * power[peak]) continue;
    return static_cast<double>(b) + step * (current - 0.5 * power[peak]) / (current - next);
  }
  return std::nullopt;
}

/// Of one resonance, half of the power is at f0 (sqrt(1 + 1 / 4Q²) ± 1 / 2Q): either side gives Q, both
/// together best.
std::optional<Resonance> resonance_of(const Spectrum& path, double hertz_per_bin, Hertz low, Hertz high) {
  std::vector<double> power(path.size(), 0.0);
  for (std::size_t b = 0; b < power.size(); ++b)
    if (const double f = static_cast<double>(b) * hertz_per_bin; f >= low.value && f <= high.value)
      power[b] = std::norm(path[b]);
  const auto peak = static_cast<std::size_t>(std::max_element(power.begin(), power.end()) - power.begin());
  const auto known = [&](const std::optional<double>& bin) {
    return bin && *bin * hertz_per_bin > 1.02 * low.value && *bin * hertz_per_bin < 0.98 * high.value;
  };
  const auto below = half_power(power, peak, -1), above = half_power(power, peak, 1);
  const auto centre = static_cast<double>(peak);
  Resonance found{centre * hertz_per_bin, 0.0};
  if (known(below) && known(above))
    found.q = centre / (*above - *below);
  else if (known(above) && centre * hertz_per_bin > 1.02 * low.value)
    found.q = centre * *above / (*above * *above - centre * centre);
  else if (known(below) && centre * hertz_per_bin < 0.98 * high.value)
    found.q = centre * *below / (centre * centre - *below * *below);
  else
    return std::nullopt;
  return found;
}

void describe_swing(const std::vector<double>& taps, Calibration& calibration) {
  const double highest = peak_of(taps);
  const auto first = std::find_if(taps.begin(), taps.end(),
                                  [&](double tap) { return std::abs(tap) >= kFirstSwing * highest; });
  if (first == taps.end()) return;
  calibration.polarity = *first < 0.0 ? -1 : 1;
  calibration.arrival_frames = static_cast<double>(first - taps.begin());
}

Finding verdict_of(const Calibration& calibration, double electrical_frames) {
  if (calibration.snr_db < kLeastSnr)
    return {Verdict::LowSnr, "the noise is too strong to determine the frequency response of the path",
            "play louder (within the actuator's limits), raise the sensor's gain, or find the source of the "
            "noise"};
  if (calibration.unexplained <= kMaxUnexplained) return {};
  if (calibration.delay_frames < electrical_frames - 1.0)
    return {Verdict::NotFlat,
            fmt::format("the probe is captured {:.0f} frames earlier than the delay of the card alone",
                        electrical_frames - calibration.delay_frames),
            "the delay to subtract is too long: measure it again with a loopback cable, the same sample rate "
            "and block size"};
  return {Verdict::NotFlat,
          "the path is not linear and time-invariant: part of the captured signal differs between probes or "
          "is distorted",
          "play softer, and make sure that nothing rattles or moves during the measurement"};
}

}  // namespace

bool spoils(Verdict verdict) {
  constexpr std::array kHarmless{Verdict::Ok, Verdict::NotFlat, Verdict::LowSnr, Verdict::DirectMonitoring};
  return std::count(kHarmless.begin(), kHarmless.end(), verdict) == 0;
}

Result<Calibration> calibrate(const LoopRecording& recording, const CalibrationSettings& settings) {
  if (!(settings.electrical_frames >= 0.0))
    return fail(Errc::BadArgument, "", "the delay of the card cannot be negative",
                "measure it with a loopback cable");
  auto analysis = analyze(recording, {settings.channel, {}});
  if (!analysis) return tl::unexpected{analysis.error()};
  Calibration calibration{std::move(*analysis)};
  if (!calibration.detected || spoils(calibration.finding.verdict)) return calibration;

  const auto& captured = recording.captured[index(settings.channel)];
  const auto rate = recording.sample_rate;
  const auto bursts = *find_bursts(recording.played, rate);
  ProbeWindows windows{bursts, rate, {}};
  const double variance = std::max(kQuietest, power_from_db(calibration.noise_floor_dbfs));
  windows.set_noise({calibration.dc, variance, {variance, variance}});
  std::vector<TrackedProbe> probes;
  for (const auto& burst : bursts.repeated) probes.push_back({.burst = burst});
  const auto window = without_delay(windows, captured, settings.electrical_frames, probes);
  auto& fourier = windows.fourier();
  auto& profile = calibration.profile;
  profile.sample_rate = rate;
  profile.taps = taps_of(window, fourier, static_cast<std::size_t>(frames_in(settings.length, rate)),
                         variance / total_power(probes));
  profile.low = measuring_probe(rate).start;
  profile.high = measuring_probe(rate).stop;

  const auto path = fourier.forward(profile.taps);
  calibration.unexplained = unexplained(window, path);
  calibration.resonance =
      resonance_of(path, rate.value / static_cast<double>(fourier.size()), profile.low, profile.high);
  describe_swing(profile.taps, calibration);
  // Group delays are looked for around the arrival.
  PathModel arrival;
  arrival.delay_frames = calibration.arrival_frames;
  const Response response{window, arrival, rate, fourier};
  calibration.spectrum = response.spectrum();
  calibration.group_delay = response.group_delay(0.0);
  calibration.finding = verdict_of(calibration, settings.electrical_frames);
  return calibration;
}

}  // namespace tactus
