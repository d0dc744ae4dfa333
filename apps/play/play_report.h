#pragma once

// Thread: [control]

#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "apps/cli/guard_options.h"
#include "backends/wav_file.h"
#include "engine/core/error.h"
#include "engine/scene/play_scene.h"

namespace tactus::app {

/// A scene to play: its file and the changes to it.
struct SceneRun {
  std::filesystem::path file;
  int block = 64;
  std::vector<std::string> set;             ///< NAME=VALUE
  std::map<std::string, double> overrides;  ///< on top of `set`, SI
  std::string delay, rate, duration;        ///< empty: as the scene says
  GuardOptions guard;
  bool show_progress = true;
  bool said = false;  ///< it was played before: what that warned of is known
};

struct PlayedScene {
  SceneSpec scene;
  SceneRecording recording;
};

/// Loads, builds and plays. All mistakes of its files in one go.
Checked<PlayedScene> play_file(const SceneRun& run);

/// {"events": [{"time_s", "node", "level_db"}]} from taps "node.output" and "node.level".
nlohmann::ordered_json events_json(const std::vector<std::string>& names,
                                   const std::vector<std::vector<double>>& taps, Hertz sample_rate);
nlohmann::ordered_json events_of(const PlayedScene& played);

/// What went through the ports of a scene, for machines and for people.
nlohmann::ordered_json ports_json(const std::vector<PortEnergy>& ports);
void print_ports(const std::vector<PortEnergy>& ports);

/// Errors: BadFile.
Status write_json(const std::string& path, const nlohmann::ordered_json& json);

/// What the instrument gave out, behind the guard: a channel for each of these outputs.
Samples outputs_of(const PlayedScene& played, const std::vector<std::string>& names);

}  // namespace tactus::app
