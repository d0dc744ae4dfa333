#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "apps/play/play_report.h"
#include "engine/core/named.h"
#include "engine/scene/measures/events.h"
#include "engine/scene/measures/notes/pitch_track.h"

namespace tactus::app {
namespace {

constexpr double kSharedAxis = 20;  // ranges that differ by more get an axis each
constexpr std::size_t kMostSubplots = 5, kMostLines = 60;

/// Largest minus least value.
double range_of(const PlotSeries& series) {
  const auto [low, high] = std::ranges::minmax(series.y);
  return high - low;
}

/// Whether a line would be drawn as a straight one: rounding errors and what lies 120 dB below its offset.
bool is_constant(const PlotSeries& series) {
  if (series.y.empty()) return true;
  const auto [low, high] = std::ranges::minmax(series.y);
  return !(high - low > std::max(1e-12, 1e-6 * std::max(std::abs(low), std::abs(high))));
}

class ScenePlotter {
 public:
  ScenePlotter(const PlayedScene& played, const PlayedScene* compared, const ShownPart& shown)
      : played_(played),
        scene_(played.scene),
        recording_(played.recording),
        compared_(compared),
        from_(shown.from_s),
        to_(std::min(shown.to_s, recording_.seconds())),
        all_(shown.all) {}

  Plot run() {
    Plot plot{.title = scene_.name,
              .subtitle = scene_.about,
              .x = {.label = "time", .unit = "s", .low = from_, .high = to_}};
    add_pitch(plot);
    add_motion();
    for (const auto& input : recording_.inputs) add_sensor(input);
    for (const auto& output : drive_names(recording_)) add_drive(output);
    if (scene_.bench)
      for (const auto& sound : recording_.sounds) add_drive(sound);
    place(plot);
    if (hits_.size() > kMostLines) hits_.clear();
    for (const double time : hits_) plot.events.push_back({.x = time, .label = {}, .color = PlotColor::Grey});
    for (const auto& event : recording_.guard.events)
      plot.events.push_back({.x = static_cast<double>(event.frame) / recording_.sample_rate.value,
                             .label = name_of(event.kind),
                             .color = PlotColor::Vermillion});
    return plot;
  }

 private:
  enum class Kind { Motion, Sensor, Drive };
  struct Candidate {
    Kind kind;
    Subplot subplot;
    double range = 0;  ///< of its first series
  };
  struct Line {
    std::string name;  ///< of its signal
    double range = 0;
    PlotSeries series;
  };

  PlotSeries trace(const std::string& label, const std::string& name, const PlayedScene& of) const {
    const auto* signal = of.recording.find(name);
    if (signal == nullptr) return {};
    const double rate = recording_.sample_rate.value;
    const auto size = static_cast<double>(signal->samples.size());
    const auto first = static_cast<std::ptrdiff_t>(std::clamp(from_ * rate, 0.0, size));
    const auto last = static_cast<std::ptrdiff_t>(std::clamp(to_ * rate, 0.0, size));
    return plot_trace(label, static_cast<double>(first) / rate, 1 / rate,
                      {signal->samples.begin() + first, signal->samples.begin() + last});
  }

  /// The line of a signal; behind those of this run, the one of the other run where it is another, named
  /// once.
  void add_lines(Subplot& subplot, const std::string& name, PlotSeries line) const {
    auto& series = subplot.series;
    if (compared_ != nullptr) {
      auto other = trace(scene_.compare->name, name, *compared_);
      if (!other.y.empty() && other.y != line.y) {
        other.color = PlotColor::Grey;
        if (std::ranges::count(series, other.label, &PlotSeries::label) > 0) other.label.clear();
        series.insert(series.begin(), std::move(other));
      }
    }
    series.push_back(std::move(line));
  }

  static std::string short_name(const std::string& name) { return name.substr(name.rfind('.') + 1); }

  /// Expected and detected pitch.
  void add_pitch(Plot& plot) const {
    const auto melody = melody_of(recording_);
    if (!melody) return;
    Subplot subplot{.y = {.label = "pitch", .unit = "Hz", .log = true, .notes = true},
                    .series = {trace("expected", melody->expected->name, played_)},
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

  /// The plant's outputs: those of one unit together, as far as their ranges fit one axis.
  void add_motion() {
    if (scene_.bench) return;  // the sensors show it
    std::vector<std::pair<std::string, std::vector<Line>>> units;
    for (const auto& signal : recording_.signals) {
      if (signal.name.starts_with("instrument.") || to_string(signal.dimension).empty() ||
          is_frequency(signal.dimension))
        continue;
      auto series = trace(short_name(signal.name), signal.name, played_);
      if (is_constant(series)) {
        constant_.push_back(short_name(signal.name));
        continue;
      }
      const double range = range_of(series);
      entry_of(units, to_string(signal.dimension)).push_back({signal.name, range, std::move(series)});
    }
    for (auto& [unit, lines] : units) {
      std::ranges::stable_sort(lines, std::greater{}, &Line::range);
      for (auto& line : lines) add_lines(subplot_for(unit, line.range), line.name, std::move(line.series));
    }
  }

  /// The value with a key, in the order of the first use.
  template <class Value>
  static Value& entry_of(std::vector<std::pair<std::string, Value>>& entries, const std::string& key) {
    for (auto& [other, value] : entries)
      if (other == key) return value;
    return entries.emplace_back(key, Value{}).second;
  }

  Subplot& subplot_for(const std::string& unit, double range) {
    const auto fits = [&](const Candidate& other) {
      return other.kind == Kind::Motion && other.subplot.y.unit == unit && other.range <= kSharedAxis * range;
    };
    if (const auto found = std::ranges::find_if(candidates_, fits); found != candidates_.end())
      return found->subplot;
    candidates_.push_back({Kind::Motion,
                           {.y = {.label = quantity_name(unit), .unit = unit},
                            .height = unit == "m" || unit == "rad" ? 2.0 : 0.8},
                           range});
    return candidates_.back().subplot;
  }

  static std::string quantity_name(const std::string& unit) {
    static const std::map<std::string, std::string> kNames = {
        {"m", "position"}, {"m/s", "velocity"}, {"m/s^2", "acceleration"},
        {"N", "force"},    {"V", "voltage"},    {"A", "current"},
        {"C", "charge"},   {"rad", "angle"},    {"rad/s", "angular velocity"},
        {"N m", "torque"}};
    const auto it = kNames.find(unit);
    return it == kNames.end() ? unit : it->second;
  }

  void add_sensor(const std::string& input) {
    const auto* signal = recording_.find("instrument." + input);
    const auto unit = to_string(signal->dimension);
    Candidate sensor{Kind::Sensor,
                     {.y = {.label = "sensor: " + input, .unit = unit.empty() ? "full scale" : unit}}};
    auto series = trace("", signal->name, played_);
    if (is_constant(series)) {
      constant_.push_back(input);
      return;
    }
    add_lines(sensor.subplot, signal->name, std::move(series));
    add_triggers(sensor.subplot);
    candidates_.push_back(std::move(sensor));
  }

  /// Shown once, with the first sensor.
  void add_triggers(Subplot& subplot) {
    if (std::exchange(triggers_shown_, true)) return;
    for (const auto& signal : recording_.signals) {
      if (!signal.name.starts_with("instrument.") || std::ranges::count(signal.name, '.') != 2 ||
          signal.name.ends_with(".level"))
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
  }

  void add_drive(const std::string& output) {
    const auto name = "instrument." + output;
    const bool sound = std::ranges::find(recording_.sounds, output) != recording_.sounds.end();
    Candidate drive{Kind::Drive,
                    {.y = {.label = (sound ? "monitor: " : "drive: ") + output, .unit = "full scale"}}};
    auto series = trace("", name, played_);
    if (is_constant(series)) {
      constant_.push_back(output);
      return;
    }
    add_lines(drive.subplot, name, std::move(series));
    add_ceiling(drive.subplot, output);
    candidates_.push_back(std::move(drive));
  }

  /// The ceiling, where it limited the drive.
  void add_ceiling(Subplot& subplot, const std::string& output) const {
    const auto* guarded = find_named(recording_.guard.outputs, output);
    if (guarded == nullptr) return;
    bool reached = false;
    for (std::size_t s = 0; s < kGuardStages; ++s)
      reached = reached || (std::string_view{name_of(GuardStage::Index{s})} == "ceiling" &&
                            guarded->counts[s].frames > 0);
    if (!reached) return;
    for (const auto& limit : guarded->limits)
      if (limit.limit == "ceiling")
        for (const double sign : {1.0, -1.0})
          subplot.levels.push_back({.y = sign * limit.value, .label = sign > 0 ? "ceiling" : ""});
  }

  /// The first subplot of each kind comes first, then the others in order.
  std::vector<bool> chosen(std::size_t room) const {
    std::vector<bool> keep(candidates_.size(), all_);
    const auto take = [&](std::size_t at) {
      if (room == 0 || keep[at]) return;
      keep[at] = true;
      --room;
    };
    for (const auto kind : {Kind::Motion, Kind::Drive, Kind::Sensor})
      if (const auto first = std::ranges::find(candidates_, kind, &Candidate::kind);
          first != candidates_.end())
        take(static_cast<std::size_t>(first - candidates_.begin()));
    for (std::size_t at = 0; at < candidates_.size(); ++at) take(at);
    return keep;
  }

  void place(Plot& plot) {
    const auto room = kMostSubplots - std::min(kMostSubplots, plot.subplots.size());
    const auto keep = chosen(room);
    const auto left_out = std::ranges::count(keep, false);
    for (std::size_t at = 0; at < candidates_.size(); ++at)
      if (keep[at]) plot.subplots.push_back(std::move(candidates_[at].subplot));
    if (!constant_.empty()) plot.subtitle += fmt::format(" Constant: {}.", fmt::join(constant_, ", "));
    if (left_out > 0)
      plot.subtitle += fmt::format(" {} further plot{}: --all-signals.", left_out, left_out > 1 ? "s" : "");
  }

  const PlayedScene& played_;
  const SceneSpec& scene_;
  const SceneRecording& recording_;
  const PlayedScene* compared_;
  double from_, to_;
  bool all_;
  std::vector<Candidate> candidates_;
  std::vector<std::string> constant_;
  std::vector<double> hits_;
  bool triggers_shown_ = false;
};

}  // namespace

Plot scene_plot(const PlayedScene& played, const PlayedScene* compared, const ShownPart& shown) {
  return ScenePlotter{played, compared, shown}.run();
}

}  // namespace tactus::app
