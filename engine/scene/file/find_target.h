#pragma once
// Thread: [control]

#include <filesystem>
#include <string>
#include <vector>

#include "engine/core/error.h"

namespace tactus {

/// What a name or a path of a user stands for.
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
/// is no file here, that of the first of `folders` that has it. Errors: BadFile where there is none, with the
/// nearest name; and for a folder without either, with the scenes that it contains.
Result<Target> find_target(const std::string& text, FolderMeans means,
                           const std::vector<std::filesystem::path>& folders);

/// The folder that the parts of a file may not leave: the "instruments" above it, or its own.
std::filesystem::path root_of(const std::filesystem::path& file);

/// Where instruments and profiles are looked up by name: the user's own folder,
/// $XDG_DATA_HOME/tactus/instruments
/// (~/.local/share/tactus/instruments), then the `shipped` one.
std::vector<std::filesystem::path> instrument_folders(const std::filesystem::path& shipped);

}  // namespace tactus
