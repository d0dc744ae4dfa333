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

}  // namespace

void add_run_options(CLI::App& command, RunOptions& options) {
  command.add_option("--delay", options.delay, "system delay instead of the scene's, such as \"10 ms\"");
  command.add_option("--rate", options.rate,
                     "sample rate instead of the scene's or the input file's, which is then resampled");
  command.add_option("--duration", options.duration,
                     "instead of the scene's or the input file's, such as \"10 s\"");
  command.add_option("--set", options.set,
                     "NAME=VALUE: a control, such as strength=0.5 or \"sensitivity=-40 dB\"; in a scene also "
                     "plant.NAME=VALUE");
  command.add_option("--block", options.block, "frames a block (the result does not depend on it)")
      ->check(CLI::Range(1, 8192));
  add_guard_options(command, options.guard);
  command.add_flag("--json", options.json, "for machines");
}

PlayedScene play_file(const std::filesystem::path& file, const RunOptions& options,
                      const std::map<std::string, double>* compared) {
  const bool first = compared == nullptr;
  auto loaded = load_scene_leniently(file, root_of(file));
  if (!loaded.scene) throw CommandError{std::move(loaded.mistakes)};
  auto& scene = *loaded.scene;
  if (!options.duration.empty()) scene.duration = or_exit(parse_duration(options.duration, 3600_s));
  SceneOptions changes;
  changes.set = or_exit(parse_settings(options.set));
  if (!first)
    for (const auto& [name, value] : *compared) changes.set[name] = value;
  if (!options.delay.empty()) changes.delay = or_exit(parse_delay(options.delay));
  if (!options.rate.empty()) changes.rate = or_exit(parse_rate(options.rate));
  scene.drives = or_exit(apply(options.guard, std::move(scene.drives), root_of(file), !first));
  auto built = or_exit(build_scene(loaded, standard_nodes(), changes));
  const auto* instrument = scene.part("instrument");
  if (first && changes.delay && instrument != nullptr && instrument->graph != nullptr)
    announce_delay(*instrument->graph, changes.delay->value);
  Progress progress{"playing " + scene.name};
  auto recording =
      or_exit(play_scene(scene, built, options.block.value_or(64), [&](double share) { progress(share); }));
  return {std::move(scene), std::move(recording)};
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

Json faults_json(const std::vector<FaultCount>& faults) {
  auto json = Json::array();
  for (const auto& fault : faults) json.push_back({{"node", fault.path}, {"count", fault.count}});
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

Json events_of(const SceneRecording& recording) {
  std::vector<std::string> names;
  std::vector<std::vector<double>> taps;
  const std::string prefix = "instrument.";
  for (const auto& signal : recording.signals) {
    if (!signal.name.starts_with(prefix) || signal.name.find('.', prefix.size()) == std::string::npos)
      continue;
    names.push_back(signal.name.substr(prefix.size()));
    taps.push_back(signal.samples);
  }
  return events_json(names, taps, recording.sample_rate);
}

}  // namespace tactus::app
