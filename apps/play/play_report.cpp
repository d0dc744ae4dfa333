#include "apps/play/play_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "apps/cli/console.h"
#include "engine/core/decibels.h"
#include "engine/nodes/table.h"
#include "engine/scene/measures/events.h"

namespace tactus::app {
namespace {

using Json = nlohmann::ordered_json;

/// Levels count the highest envelope of a hit's first 5 ms.
constexpr double kLevelAfter_s = 5e-3;

Result<SceneOptions> scene_options(const SceneRun& run) {
  SceneOptions options;
  auto set = parse_settings(run.set);
  if (!set) return tl::unexpected(set.error());
  options.set = std::move(*set);
  for (const auto& [name, value] : run.overrides) options.set[name] = value;
  if (!run.delay.empty()) {
    const auto delay = parse_option(run.delay, "s", "delay");
    if (!delay) return tl::unexpected(delay.error());
    if (*delay < 0 || *delay > 10)
      return fail(Errc::OutOfRange, "--delay", "must be between 0 s and 10 s", "");
    options.delay = Seconds{*delay};
  }
  if (!run.rate.empty()) {
    const auto rate = parse_rate(run.rate);
    if (!rate) return tl::unexpected(rate.error());
    options.rate = *rate;
  }
  return options;
}

}  // namespace

Checked<PlayedScene> play_file(const SceneRun& run) {
  auto loaded = load_scene_leniently(run.file, root_of(run.file));
  if (!loaded.scene) return tl::unexpected(std::move(loaded.errors));
  auto& scene = loaded.scene;
  if (!run.duration.empty()) {
    const auto duration = parse_option(run.duration, "s", "duration");
    if (!duration) return tl::unexpected(std::vector{duration.error()});
    if (!(*duration > 0) || *duration > 3600)
      return tl::unexpected(
          std::vector{Error{Errc::OutOfRange, "--duration", "must be above 0 s and at most an hour", ""}});
    scene->duration = Seconds{*duration};
  }
  const auto options = scene_options(run);
  if (!options) return tl::unexpected(std::vector{options.error()});
  auto drives = apply(run.guard, std::move(scene->drives), root_of(run.file), run.said);
  if (!drives) return tl::unexpected(drives.error());
  scene->drives = std::move(*drives);
  auto built = build_scene(loaded, standard_nodes(), *options);
  if (!built) return tl::unexpected(built.error());
  const auto* instrument = scene->part("instrument");
  if (!run.said && options->delay && instrument != nullptr && instrument->graph != nullptr)
    announce_delay(*instrument->graph, options->delay->value);
  Progress progress{"playing " + scene->name};
  auto recording = play_scene(*scene, *built, run.block, [&](double share) {
    if (run.show_progress) progress(share);
  });
  if (!recording) return tl::unexpected(std::vector{recording.error()});
  return PlayedScene{std::move(*scene), std::move(*recording)};
}

Json events_json(const std::vector<std::string>& names, const std::vector<std::vector<double>>& taps,
                 Hertz sample_rate) {
  struct Event {
    double time_s;
    std::string node;
    double level;
  };
  std::vector<Event> events;
  for (std::size_t t = 0; t < names.size(); ++t) {
    const auto node = names[t].substr(0, names[t].rfind('.'));
    if (names[t] == node + ".level") continue;
    const auto level = std::find(names.begin(), names.end(), node + ".level") - names.begin();
    const auto times = trigger_times(taps[t], sample_rate);
    for (std::size_t i = 0; i < times.size(); ++i) {
      double value = std::nan("");
      if (level < static_cast<std::ptrdiff_t>(names.size())) {
        const auto& levels = taps[static_cast<std::size_t>(level)];
        const double until = i + 1 < times.size() ? std::min(times[i] + kLevelAfter_s, times[i + 1])
                                                  : times[i] + kLevelAfter_s;
        value = levels[std::min(levels.size() - 1, static_cast<std::size_t>(until * sample_rate.value))];
      }
      events.push_back({times[i], node, value});
    }
  }
  std::stable_sort(events.begin(), events.end(),
                   [](const Event& a, const Event& b) { return a.time_s < b.time_s; });
  Json json{{"events", Json::array()}};
  for (const auto& event : events) {
    Json entry{{"time_s", event.time_s}, {"node", event.node}};
    if (event.level > 0) entry["level_db"] = amplitude_to_db(event.level);
    json["events"].push_back(entry);
  }
  return json;
}

Json ports_json(const std::vector<PortEnergy>& ports) {
  auto json = Json::array();
  for (const auto& port : ports) {
    json.push_back({{"port", port.name},
                    {"allowed_j", port.allowed},
                    {"given_j", port.given},
                    {"net_j", port.net},
                    {"active", port.active_at_s.has_value()}});
    if (!port.active_at_s) continue;
    json.back()["active_at_s"] = *port.active_at_s;
    json.back()["growth_w"] = port.growth_w;
  }
  return json;
}

void print_ports(const std::vector<PortEnergy>& ports) {
  const char* title = "energy";
  for (const auto& port : ports) fmt::print("  {:<20}{}\n", std::exchange(title, ""), in_words(port));
}

Status write_json(const std::string& path, const Json& json) {
  std::ofstream file{path};
  file << json.dump(2) << "\n";
  if (file) return {};
  return fail(Errc::BadFile, path, "cannot be written", "choose a folder that exists and can be written");
}

Json events_of(const PlayedScene& played) {
  std::vector<std::string> names;
  std::vector<std::vector<double>> taps;
  const std::string prefix = "instrument.";
  for (const auto& signal : played.recording.signals) {
    if (!signal.name.starts_with(prefix) || signal.name.find('.', prefix.size()) == std::string::npos)
      continue;
    names.push_back(signal.name.substr(prefix.size()));
    taps.push_back(signal.samples);
  }
  return events_json(names, taps, played.recording.sample_rate);
}

Samples outputs_of(const PlayedScene& played, const std::vector<std::string>& names) {
  Samples samples;
  samples.sample_rate = played.recording.sample_rate;
  for (const auto& name : names)
    samples.channels.push_back(played.recording.find("instrument." + name)->samples);
  return samples;
}

}  // namespace tactus::app
