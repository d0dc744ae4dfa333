#include "engine/scene/file/find_target.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>

#include "engine/graph/file/error_list.h"
#include "engine/graph/file/load.h"
#include "engine/scene/file/scene_spec.h"

namespace tactus {
namespace {

namespace fs = std::filesystem;

constexpr const char* kScene = "scene.toml";
constexpr const char* kInstrument = "instrument.toml";

std::vector<fs::path> entries_of(const fs::path& folder) {
  std::error_code none;
  std::vector<fs::path> entries;
  for (const auto& entry : fs::directory_iterator{folder, none}) entries.push_back(entry.path());
  std::ranges::sort(entries);
  return entries;
}

bool is_scene_file(const fs::path& file) {
  if (file.extension() != ".toml" || !fs::is_regular_file(file)) return false;
  const auto table = load_toml(file);
  return table && is_scene(*table);
}

/// What a user can name instead of a folder without a scene: its scenes, else its folders with scenes or an
/// instrument.
std::vector<std::string> playable_in(const fs::path& folder) {
  std::vector<std::string> found;
  for (const auto& entry : entries_of(folder))
    if (is_scene_file(entry)) found.push_back(entry.generic_string());
  if (!found.empty()) return found;
  for (const auto& entry : entries_of(folder))
    if (fs::exists(entry / kInstrument) || std::ranges::any_of(entries_of(entry), is_scene_file))
      found.push_back(entry.generic_string());
  return found;
}

Result<fs::path> file_in(const fs::path& folder, FolderMeans means) {
  const bool scene = means == FolderMeans::Scene;
  for (const auto* name : {scene ? kScene : kInstrument, scene ? kInstrument : kScene})
    if (fs::exists(folder / name)) return folder / name;
  const auto playable = playable_in(folder);
  return fail(Errc::BadFile, folder.generic_string(),
              fmt::format("this folder has no {} and no {}", kScene, kInstrument),
              playable.empty() ? "name a file" : fmt::format("name one of {}", fmt::join(playable, ", ")));
}

/// "haptic_drum" of "instruments/haptic_drum": as the documents call what is shipped.
fs::path without_collection(const fs::path& path) {
  fs::path rest;
  for (auto part = path.begin(); part != path.end(); ++part)
    if (part != path.begin() || *part != "instruments") rest /= *part;
  return rest;
}

Error missing(const std::string& text, const std::vector<fs::path>& folders) {
  std::vector<std::string> names;
  for (const auto& folder : folders)
    for (const auto& entry : entries_of(folder)) names.push_back(entry.filename().generic_string());
  const auto folder = fs::path{text}.parent_path();
  for (const auto& entry : entries_of(folder.empty() ? "." : folder))
    if (fs::is_directory(entry) || entry.extension() == ".toml")
      names.push_back((folder / entry.filename()).generic_string());
  return {Errc::BadFile, text, "there is no such file",
          suggest(text, names, "check the path; 'tactus list' shows what can be played")};
}

}  // namespace

fs::path Target::root() const { return root_of(file); }

Result<Target> find_target(const std::string& text, FolderMeans means, const std::vector<fs::path>& folders) {
  std::error_code none;
  fs::path path{text};
  if (!fs::exists(path, none) && path.is_relative())
    for (const auto& folder : folders)
      if (const auto shipped = folder / without_collection(text); fs::exists(shipped, none)) {
        path = shipped;
        break;
      }
  if (!fs::exists(path, none)) return tl::unexpected(missing(text, folders));
  const Result<fs::path> file = fs::is_directory(path, none) ? file_in(path, means) : path;
  return file.map([](const fs::path& found) {
    const auto table = load_toml(found);
    return Target{found, table && is_scene(*table)};
  });
}

fs::path root_of(const fs::path& file) {
  const auto absolute = fs::absolute(file).lexically_normal();
  for (auto folder = absolute.parent_path(); folder.has_relative_path(); folder = folder.parent_path())
    if (folder.filename() == "instruments") return folder;
  return file.has_parent_path() ? file.parent_path() : fs::path{"."};
}

std::vector<fs::path> instrument_folders(const fs::path& shipped) {
  const char* data = std::getenv("XDG_DATA_HOME");
  const char* home = std::getenv("HOME");
  std::vector<fs::path> folders = {shipped};
  if (data != nullptr && *data != '\0')
    folders.insert(folders.begin(), fs::path{data} / "tactus/instruments");
  else if (home != nullptr && *home != '\0')
    folders.insert(folders.begin(), fs::path{home} / ".local/share/tactus/instruments");
  return folders;
}

}  // namespace tactus
