#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "apps/latency/latency.h"
#include "engine/core/decibels.h"
#include "engine/core/index.h"

namespace tactus::app {
namespace {

constexpr double kBefore_s = 0.001, kAfter_s = 0.004;  // that the impulse response is shown around the delay
constexpr double kRinging_s = 0.06;                    // and of an actuator, after the drive
constexpr double kFloor_db = -120.0;

PlotSeries around_delay(const Analysis& analysis, double after_s) {
  const double rate = analysis.sample_rate.value;
  PlotSeries shown;
  for (std::size_t n = 0; n < analysis.response.size(); ++n) {
    const double at = (static_cast<double>(analysis.response_at) + static_cast<double>(n)) / rate;
    const double from_delay = at - analysis.delay_frames / rate;
    if (from_delay < -kBefore_s || from_delay > after_s) continue;
    shown.x.push_back(at);
    shown.y.push_back(analysis.response[n]);
  }
  return shown;
}

/// The largest magnitude within two frames, relative to the highest of all. A Hilbert transform would draw
/// the tail 1 / t of whatever lies near 0 Hz over everything that comes late.
std::vector<double> envelope_db(const std::vector<double>& samples) {
  const auto count = static_cast<std::ptrdiff_t>(samples.size());
  std::vector<double> envelope;
  double highest = 1e-12;
  for (std::ptrdiff_t n = 0; n < count; ++n) {
    double most = 1e-12;
    for (auto m = std::max<std::ptrdiff_t>(0, n - 2); m <= std::min(count - 1, n + 2); ++m)
      most = std::max(most, std::abs(samples[index(m)]));
    envelope.push_back(most);
    highest = std::max(highest, most);
  }
  for (auto& level : envelope) level = std::max(kFloor_db, amplitude_to_db(level / highest));
  return envelope;
}

/// `marked`: the delay is one to be trusted.
Plot response_plot(const Analysis& analysis, bool marked, double after_s) {
  auto shown = around_delay(analysis, after_s);
  Plot plot;
  plot.x = {.label = "delay", .unit = "s"};
  Subplot linear, envelope;
  linear.y = {.label = "impulse response"};
  linear.series = {shown};
  linear.height = 1.3;
  if (marked)
    linear.events = {{.x = analysis.delay_frames / analysis.sample_rate.value,
                      .label = fmt::format("{:.2f} frames", analysis.delay_frames),
                      .color = PlotColor::Vermillion}};
  envelope.y = {.label = "envelope", .unit = "dB", .high = 3.0};
  shown.y = envelope_db(shown.y);
  envelope.series = {shown};
  plot.subplots = {linear, envelope};
  return plot;
}

/// The group delay of each octave, beside the delay and so many standard errors from it.
PlotSeries delays_of(const Analysis& analysis, std::initializer_list<double> errors) {
  PlotSeries delays{.label = {}, .color = PlotColor::Blue};
  for (const auto& band : analysis.group_delay)
    for (const double error : errors) {
      delays.x.push_back(band.centre_hz);
      delays.y.push_back(band.delay_frames - analysis.delay_frames + error * band.standard_error_frames);
    }
  return delays;
}

Plot spectrum_plot(const Analysis& analysis) {
  Plot plot;
  plot.x = {
      .label = "frequency", .unit = "Hz", .low = 16.0, .high = 0.5 * analysis.sample_rate.value, .log = true};
  Subplot gain;
  gain.y = {.label = "gain of the path", .unit = "dB"};
  gain.height = 1.3;
  PlotSeries path{.label = "path", .color = PlotColor::Blue};
  PlotSeries noise{.label = "noise", .color = PlotColor::Grey};
  for (const auto& point : analysis.spectrum) {
    path.x.push_back(point.frequency_hz);
    path.y.push_back(point.gain_db);
    noise.x.push_back(point.frequency_hz);
    noise.y.push_back(point.noise_db);
  }
  gain.series = {path, noise};
  plot.subplots = {gain};
  if (analysis.group_delay.empty()) return plot;
  Subplot groups;
  groups.y = {.label = "group delay per octave, minus the delay", .unit = "frames"};
  groups.series = {delays_of(analysis, {-1.0, 1.0, std::nan("")}), delays_of(analysis, {0.0})};
  groups.series.back().mark = PlotMark::Points;
  groups.levels = {{.y = 0.0}};
  plot.subplots.push_back(groups);
  return plot;
}

/// Noise alone must not fill the subplot.
void widen_axis(const std::vector<double>& values, PlotAxis& axis) {
  constexpr double kLeast = 0.001;  // frames
  if (values.empty()) return;
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  if (*high - *low >= kLeast) return;
  axis.low = 0.5 * (*low + *high - kLeast);
  axis.high = *axis.low + kLeast;
}

/// Every probe of every opening, one opening after the other.
Plot probes_plot(const LatencyReport& report) {
  const auto& openings = report.measurement.openings;
  Plot plot;
  plot.x = {.label = openings.size() > 1 ? "probe, in playing order" : "probe"};
  Subplot subplot;
  subplot.y = {.label = "delay of each probe", .unit = "frames"};
  PlotSeries points{.label = {}, .mark = PlotMark::Points, .color = PlotColor::Blue};
  for (std::size_t o = 0; o < openings.size(); ++o) {
    const auto before = static_cast<double>(points.x.size());
    for (const auto& probe : openings[o].analysis.probes) {
      points.x.push_back(static_cast<double>(points.x.size() + 1));
      points.y.push_back(probe.delay_frames);
    }
    if (openings.size() > 1)
      subplot.bands.push_back({.from = before + 0.5,
                               .to = static_cast<double>(points.x.size()) + 0.5,
                               .label = fmt::format("opening {}", o + 1),
                               .color = o % 2 == 0 ? PlotColor::Sky : PlotColor::Grey});
  }
  subplot.series = {points};
  widen_axis(points.y, subplot.y);
  if (report.ok())
    subplot.levels = {
        {.y = report.measurement.delay_frames, .label = "mean", .color = PlotColor::Vermillion}};
  plot.subplots = {subplot};
  return plot;
}

std::string describe_analysis(const LatencyReport& report, const Analysis& analysis) {
  auto text = report.source;
  if (!report.ok()) text += ". Cause: " + report.measurement.finding.what;
  if (!analysis.detected) return text;
  text += fmt::format(". Gain {} dB, {}; {:.0f} dB above the noise", fixed(analysis.gain_db, 1),
                      polarity_text(analysis.polarity), analysis.snr_db);
  if (report.measurement.reported_frames)
    text += fmt::format("; the driver reports {:.0f} frames", *report.measurement.reported_frames);
  return text + ".";
}

}  // namespace

std::vector<Plot> picture_of(const LatencyReport& report) {
  const auto& analysis = report.measurement.shown().analysis;
  auto page = analysis.detected ? std::vector{response_plot(analysis, report.ok(), kAfter_s),
                                              spectrum_plot(analysis), probes_plot(report)}
                                : std::vector{Plot{}};
  page.front().title = report.ok() ? "Delay " + delay_text(report.measurement, report.sample_rate())
                                   : fmt::format("No delay: {}", code(report.measurement.finding.verdict));
  page.front().subtitle = describe_analysis(report, analysis);
  return page;
}

std::vector<Plot> picture_of(const Calibration& calibration) {
  Analysis path = calibration;
  path.response = calibration.profile.taps;
  path.response_at = 0;
  path.delay_frames = 0;
  std::vector page{response_plot(path, false, kRinging_s), spectrum_plot(path)};
  const auto verdict = calibration.finding.verdict;
  page.front().title = verdict == Verdict::Ok ? fmt::format("Path, {}", polarity_text(calibration.polarity))
                                              : fmt::format("No profile: {}", code(verdict));
  auto& subtitle = page.front().subtitle;
  if (const auto& resonance = calibration.resonance)
    subtitle = fmt::format("Resonance {:.1f} Hz, Q {:.2f}; ", resonance->frequency_hz, resonance->q);
  subtitle +=
      fmt::format("{:.0f} dB above the noise. The delay of the card is subtracted.", calibration.snr_db);
  return page;
}

}  // namespace tactus::app
