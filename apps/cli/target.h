#pragma once
// Thread: [control]

#include <filesystem>
#include <string>
#include <vector>

#include "engine/scene/file/scene_spec.h"

namespace tactus::app {

/// What a FILE argument names.
struct Target {
  std::filesystem::path file;
  bool scene = false;  ///< else an instrument, a plant or a part

  /// The folder that its parts may not leave.
  std::filesystem::path root() const;
};

/// Which file a folder stands for: its scene.toml, or where real inputs replace the simulated world, its
/// instrument.toml. A folder with only one of them stands for that one.
enum class FolderMeans { Scene, Instrument };

/// The file that `text` names: itself, the one that the folder stands for, or of a name such as "wall" that
/// is no file here, the shipped instrument. Throws a CommandError for a folder without either, with the
/// scenes that it contains.
Target resolve_target(const std::string& text, FolderMeans means = FolderMeans::Scene);

/// The folder that the parts of a file may not leave: the "instruments" above it, or its own.
std::filesystem::path root_of(const std::filesystem::path& file);

/// The folder with the shipped instruments and profiles: that of the installation, else of the source code.
std::filesystem::path shipped_instruments();
/// Where instruments and profiles are looked up by name: the user's own folder,
/// $XDG_DATA_HOME/tactus/instruments
/// (~/.local/share/tactus/instruments), then the shipped one.
std::vector<std::filesystem::path> instrument_folders();

/// The scene of a target, with its profiles; with the errors of the text, or without it.
LoadedScene load_scene_leniently(const Target& target);
Checked<SceneSpec> load_scene(const Target& target);

}  // namespace tactus::app
