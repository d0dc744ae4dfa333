#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "apps/play/play_report.h"
#include "engine/scene/measures/events.h"
#include "engine/scene/measures/notes/pitch_track.h"

namespace tactus::app {
namespace {

class ScenePlotter {
 public:
  ScenePlotter(const SceneSpec& scene, const SceneRecording& recording, double from_s, double to_s)
      : scene_(scene), recording_(recording), from_(from_s), to_(std::min(to_s, recording.seconds())) {}

  Plot run() {
    Plot plot{.title = scene_.name,
              .subtitle = scene_.about,
              .x = {.label = "time", .unit = "s", .low = from_, .high = to_}};
    add_pitch(plot);
    add_motion(plot);
    for (const auto& input : recording_.inputs) add_sensor(plot, input);
    add_drives(plot);
    for (const double time : hits_) plot.events.push_back({.x = time, .label = {}, .color = PlotColor::Grey});
    return plot;
  }

 private:
  PlotSeries trace(const std::string& label, const RecordedSignal& signal) const {
    const double rate = recording_.sample_rate.value;
    const auto size = static_cast<double>(signal.samples.size());
    const auto first = static_cast<std::ptrdiff_t>(std::clamp(from_ * rate, 0.0, size));
    const auto last = static_cast<std::ptrdiff_t>(std::clamp(to_ * rate, 0.0, size));
    return plot_trace(label, static_cast<double>(first) / rate, 1 / rate,
                      {signal.samples.begin() + first, signal.samples.begin() + last});
  }

  static std::string short_name(const std::string& name) { return name.substr(name.rfind('.') + 1); }

  /// Expected and detected pitch.
  void add_pitch(Plot& plot) const {
    const auto melody = melody_of(recording_);
    if (!melody) return;
    Subplot subplot{.y = {.label = "pitch", .unit = "Hz", .log = true, .notes = true},
                    .series = {trace("expected", *melody->expected)},
                    .height = 1.6};
    PlotSeries detected{.label = "detected", .color = PlotColor::Vermillion};
    for (const auto& point : melody->detected) {
      if (point.time_s < from_ || point.time_s > to_) continue;
      // A gap where there was no pitch, and where another note begins.
      if (!detected.x.empty() && (point.time_s > detected.x.back() + 1.5 * kPitchHop_s ||
                                  std::abs(cents(point.hertz, detected.y.back())) > kNearPartial_cents)) {
        detected.add(point.time_s, std::numeric_limits<double>::quiet_NaN());
      }
      detected.add(point.time_s, point.hertz);
    }
    subplot.series.push_back(std::move(detected));
    plot.subplots.push_back(std::move(subplot));
    plot.subtitle += " Detected: " + describe(melody->notes) + ".";
  }

  /// The plant's outputs, those of one unit together.
  void add_motion(Plot& plot) const {
    std::vector<std::pair<std::string, Subplot>> subplots;
    for (const auto& signal : recording_.signals) {
      if (signal.name.starts_with("instrument.") || signal.dimension.plain() ||
          signal.dimension == Dimension{.second = -1})
        continue;
      const auto unit = to_string(signal.dimension);
      auto subplot = std::ranges::find(subplots, unit, &std::pair<std::string, Subplot>::first);
      if (subplot == subplots.end()) {
        subplots.emplace_back(unit, Subplot{.y = {.label = quantity_name(unit), .unit = unit},
                                            .height = unit == "m" ? 2.0 : 0.8});
        subplot = subplots.end() - 1;
      }
      subplot->second.series.push_back(trace(short_name(signal.name), signal));
    }
    for (auto& [unit, subplot] : subplots) plot.subplots.push_back(std::move(subplot));
  }

  static std::string quantity_name(const std::string& unit) {
    static const std::map<std::string, std::string> kNames = {
        {"m", "position"}, {"m/s", "velocity"}, {"N", "force"}, {"V", "voltage"}, {"A", "current"}};
    const auto it = kNames.find(unit);
    return it == kNames.end() ? unit : it->second;
  }

  void add_sensor(Plot& plot, const std::string& input) {
    auto subplot = signal_subplot("sensor", input);
    // Triggers are shown once, with the first input.
    for (const auto& signal : recording_.signals) {
      if (input != recording_.inputs.front() || !signal.name.starts_with("instrument.") ||
          std::ranges::count(signal.name, '.') != 2 || signal.name.ends_with(".level"))
        continue;
      PlotSeries marks{.label = signal.name.substr(11, signal.name.rfind('.') - 11),
                       .mark = PlotMark::Points};
      for (const double time : trigger_times(signal.samples, recording_.sample_rate)) {
        if (time < from_ || time > to_) continue;
        marks.add(time, 0);
        hits_.push_back(time);
      }
      subplot.series.push_back(std::move(marks));
    }
    plot.subplots.push_back(std::move(subplot));
  }

  void add_drives(Plot& plot) const {
    for (const auto& output : drive_names(recording_))
      plot.subplots.push_back(signal_subplot("drive", output));
  }

  Subplot signal_subplot(const std::string& kind, const std::string& name) const {
    return {.y = {.label = kind + ": " + name},
            .series = {trace(name, *recording_.find("instrument." + name))}};
  }

  const SceneSpec& scene_;
  const SceneRecording& recording_;
  double from_, to_;
  std::vector<double> hits_;
};

}  // namespace

Plot scene_plot(const PlayedScene& played, double from_s, double to_s) {
  return ScenePlotter{played.scene, played.recording, from_s, to_s}.run();
}

}  // namespace tactus::app
