#pragma once
// Thread: [control]

#include <filesystem>
#include <string>
#include <vector>

#include "engine/scene/file/find_target.h"
#include "engine/scene/file/scene_spec.h"

namespace tactus::app {

/// The file that `text` names; of a name such as "wall" that is no file here, the user's own or the shipped
/// instrument (see find_target). Throws a CommandError for what does not exist, and for a folder without
/// scene and instrument, with the scenes that it contains.
Target resolve_target(const std::string& text, FolderMeans means = FolderMeans::Scene);

/// The folder with the shipped instruments and profiles: that of the installation, else of the source code.
std::filesystem::path shipped_instruments();
/// Where instruments and profiles are looked up by name: see tactus::instrument_folders.
std::vector<std::filesystem::path> instrument_folders();

/// The scene of a target, with its profiles; with the errors of the text, or without it.
LoadedScene load_scene_leniently(const Target& target);
Checked<SceneSpec> load_scene(const Target& target);

}  // namespace tactus::app
