#include "engine/study/scene_plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "engine/scene/measures/events.h"
#include "engine/scene/measures/notes/format_note.h"
#include "engine/scene/measures/notes/standing_tone.h"

namespace tactus {
namespace {

class Story {
 public:
  Story(const SceneSpec& scene, const SceneRecording& recording, double from_s, double to_s)
      : scene_(scene), recording_(recording), from_(from_s), to_(std::min(to_s, recording.seconds())) {}

  Figure run() {
    Figure figure;
    figure.title = scene_.name;
    figure.subtitle = scene_.about;
    figure.x = {.label = "time", .unit = "s", .low = from_, .high = to_};
    add_pitch(figure);
    add_motions(figure);
    for (const auto& input : recording_.inputs) add_heard(figure, input);
    add_given(figure);
    for (const double time : hits_)
      figure.events.push_back({.x = time, .label = {}, .color = PlotColor::Grey});
    return figure;
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

  /// What was to be played and what was heard.
  void add_pitch(Figure& figure) const {
    const auto melody = melody_of(recording_);
    if (!melody) return;
    PlotPanel panel;
    panel.y = {.label = "pitch", .unit = "Hz", .log = true, .notes = true};
    panel.height = 1.6;
    panel.series.push_back(trace("wanted", *melody->wanted));
    PlotSeries heard{.label = "heard", .color = PlotColor::Vermillion};
    for (const auto& point : melody->heard) {
      if (point.time_s < from_ || point.time_s > to_) continue;
      // A gap where nothing had a pitch for a while, and where another note begins.
      if (!heard.x.empty() && (point.time_s > heard.x.back() + 1.5 * kPitchHop_s ||
                               std::abs(cents(point.hertz, heard.y.back())) > kNearPartial_cents)) {
        heard.x.push_back(point.time_s);
        heard.y.push_back(std::numeric_limits<double>::quiet_NaN());
      }
      heard.x.push_back(point.time_s);
      heard.y.push_back(point.hertz);
    }
    panel.series.push_back(std::move(heard));
    figure.panels.push_back(std::move(panel));
    figure.subtitle += " Heard: " + in_words(melody->notes) + ".";
  }

  static bool is_pitch(const RecordedSignal& signal) {
    static const auto kHertz = parse_unit("Hz")->dimension;
    return signal.dimension == kHertz;
  }

  /// The plant's outputs, those of one unit together.
  void add_motions(Figure& figure) const {
    std::vector<std::pair<std::string, PlotPanel>> panels;
    for (const auto& signal : recording_.signals) {
      if (signal.name.starts_with("instrument.") || signal.dimension.plain() || is_pitch(signal)) continue;
      const auto unit = to_string(signal.dimension);
      auto panel = std::find_if(panels.begin(), panels.end(), [&](const auto& p) { return p.first == unit; });
      if (panel == panels.end()) {
        panels.emplace_back(unit, PlotPanel{});
        panel = panels.end() - 1;
        panel->second.y = {.label = quantity_name(unit), .unit = unit};
        panel->second.height = unit == "m" ? 2.0 : 0.8;
      }
      panel->second.series.push_back(trace(short_name(signal.name), signal));
    }
    for (auto& [unit, panel] : panels) figure.panels.push_back(std::move(panel));
  }

  static std::string quantity_name(const std::string& unit) {
    static const std::map<std::string, std::string> kNames = {
        {"m", "position"}, {"m/s", "velocity"}, {"N", "force"}, {"V", "voltage"}, {"A", "current"}};
    const auto it = kNames.find(unit);
    return it == kNames.end() ? unit : it->second;
  }

  void add_heard(Figure& figure, const std::string& input) {
    PlotPanel panel;
    panel.y = {.label = "what the instrument hears", .unit = ""};
    panel.series.push_back(trace(input, *recording_.find("instrument." + input)));
    // What it noticed stands once, with what it hears first.
    for (const auto& signal : recording_.signals) {
      if (input != recording_.inputs.front() || !signal.name.starts_with("instrument.") ||
          std::count(signal.name.begin(), signal.name.end(), '.') != 2 || signal.name.ends_with(".level"))
        continue;
      PlotSeries marks{.label = signal.name.substr(11, signal.name.rfind('.') - 11),
                       .mark = PlotMark::Points};
      for (const double time : trigger_times(signal.samples, recording_.sample_rate)) {
        if (time < from_ || time > to_) continue;
        marks.x.push_back(time);
        marks.y.push_back(0);
        hits_.push_back(time);
      }
      panel.series.push_back(std::move(marks));
    }
    figure.panels.push_back(std::move(panel));
  }

  void add_given(Figure& figure) const {
    for (const auto& output : drive_names(recording_)) {
      PlotPanel panel;
      panel.y = {.label = "what the instrument gives", .unit = ""};
      panel.series.push_back(trace(output, *recording_.find("instrument." + output)));
      figure.panels.push_back(std::move(panel));
    }
  }

  const SceneSpec& scene_;
  const SceneRecording& recording_;
  double from_, to_;
  std::vector<double> hits_;
};

}  // namespace

Figure story(const SceneSpec& scene, const SceneRecording& recording, double from_s, double to_s) {
  return Story{scene, recording, from_s, to_s}.run();
}

}  // namespace tactus
