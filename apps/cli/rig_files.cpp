#include "apps/cli/rig_files.h"

#include "apps/cli/console.h"
#include "engine/core/files.h"

namespace tactus::app {

namespace fs = std::filesystem;

fs::path shipped_instruments() {
  std::error_code error;
  const auto program = fs::read_symlink("/proc/self/exe", error);
  const auto installed = program.parent_path().parent_path() / "share/tactus/instruments";
  if (fs::is_directory(installed / "profiles", error)) return installed;
  return fs::path{TACTUS_SOURCE_DIR} / "instruments";
}

ProfilePlaces profile_places(const fs::path& rig_file) {
  const auto folder = rig_file.parent_path();
  return {folder, folder, {folder, root_of(rig_file), shipped_instruments()}};
}

ProfileFolders option_profile_folders() { return {shipped_instruments(), ".", "instruments"}; }

Rig open_rig(const fs::path& file) { return or_exit(load_rig(file, profile_places(file)), kBadFile); }

std::vector<Error> change_rig(const fs::path& file, const Rig::Device& device,
                              const std::function<void(Rig&)>& change) {
  auto rig = load_rig(file, profile_places(file));
  if (!rig) return rig.error();
  if (rig->device.output != device.output || rig->device.input != device.input)
    return {{Errc::BadFile, file.string(), "this rig was changed, and is for another device now",
             "start again with the changed rig"}};
  change(*rig);
  std::error_code ignored;
  auto former = file;
  former += "~";
  fs::copy_file(file, former, fs::copy_options::overwrite_existing, ignored);
  if (const auto written = replace_file(file, to_text(*rig)); !written) return {written.error()};
  return {};
}

}  // namespace tactus::app
