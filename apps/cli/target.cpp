#include "apps/cli/target.h"

#include "apps/cli/console.h"

namespace tactus::app {

namespace fs = std::filesystem;

Target resolve_target(const std::string& text, FolderMeans means) {
  return or_exit(find_target(text, means, instrument_folders()), kBadFile);
}

std::vector<fs::path> instrument_folders() { return tactus::instrument_folders(shipped_instruments()); }

LoadedScene load_scene_leniently(const Target& target) {
  return tactus::load_scene_leniently(target.file, target.root(), instrument_folders());
}

Checked<SceneSpec> load_scene(const Target& target) {
  return tactus::load_scene(target.file, target.root(), instrument_folders());
}

fs::path shipped_instruments() {
  std::error_code error;
  const auto program = fs::read_symlink("/proc/self/exe", error);
  const auto installed = program.parent_path().parent_path() / "share/tactus/instruments";
  if (fs::is_directory(installed / "profiles", error)) return installed;
  return fs::path{TACTUS_SOURCE_DIR} / "instruments";
}

}  // namespace tactus::app
