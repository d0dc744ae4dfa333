#pragma once

#include <filesystem>
#include <optional>
#include <stdexcept>
#include <utility>

#include "engine/nodes/table.h"
#include "engine/scene/play_scene.h"

namespace tactus::test {

/// The folder of the instruments that come along.
inline const std::filesystem::path kInstruments = std::filesystem::path{TACTUS_SOURCE_DIR} / "instruments";

/// A scene from there, by its path within. Throws what is wrong with it.
inline SceneSpec shipped_scene(const std::filesystem::path& file) {
  auto scene = load_scene(kInstruments / file, kInstruments);
  if (!scene) throw std::runtime_error(to_string(scene.error()));
  return std::move(*scene);
}

inline SceneRecording play(const SceneSpec& scene, const SceneOptions& options = {}) {
  auto built = build_scene(scene, standard_nodes(), options);
  if (!built) throw std::runtime_error(to_string(built.error()));
  auto recording = play_scene(scene, *built, 256);
  if (!recording) throw std::runtime_error(to_string(recording.error()));
  return std::move(*recording);
}

struct Played {
  SceneSpec scene;
  SceneRecording recording;
};

/// A scene from there, as long as it says or as is said here.
inline Played play(const std::filesystem::path& file, const SceneOptions& options = {},
                   std::optional<Seconds> duration = {}) {
  auto scene = shipped_scene(file);
  scene.duration = duration.value_or(scene.duration);
  auto recording = play(scene, options);
  return {std::move(scene), std::move(recording)};
}

}  // namespace tactus::test
