#include "apps/cli/rig_files.h"

#include <fmt/format.h>

#include <numbers>

#include "apps/cli/backends.h"
#include "apps/cli/console.h"
#include "apps/cli/target.h"
#include "engine/core/files.h"
#include "engine/core/prefixed.h"
#include "engine/rig/check_rig.h"

namespace tactus::app {

namespace fs = std::filesystem;

std::string decay_text(Hertz highpass) {
  return fmt::format("a constant force decays with a time constant of {} = 1/(2 pi {})",
                     prefixed(1 / (2 * std::numbers::pi * highpass.value), "s"),
                     prefixed(highpass.value, "Hz"));
}

ProfilePlaces profile_places(const fs::path& rig_file) {
  const auto folder = rig_file.parent_path();
  ProfilePlaces places{folder, folder, {folder, root_of(rig_file)}};
  for (const auto& named : instrument_folders()) places.named.push_back(named);
  return places;
}

ProfileFolders option_profile_folders() {
  auto folders = instrument_folders();
  folders.insert(folders.end(), {".", "instruments"});
  return folders;
}

Rig open_rig(const fs::path& file) {
  auto rig = or_exit(load_rig(file, profile_places(file)), kBadFile);
  or_exit(check_devices(rig.device), kBadFile);
  return rig;
}

void fit(LoadedGraph& instrument, const Rig& rig) {
  for (auto& error : check_rig(rig, *instrument.spec)) instrument.errors.push_back(std::move(error));
  instrument.spec = without_left_out(rig, instrument.spec);
}

std::vector<Error> change_rig(const fs::path& file, const Rig::Device& device,
                              const std::function<void(Rig&)>& change) {
  auto rig = load_rig(file, profile_places(file));
  if (!rig) return rig.error();
  if (rig->device.output != device.output || rig->device.input != device.input ||
      rig->device.second != device.second)
    return {{Errc::BadFile, file.string(), "this rig was changed, and is for another device now",
             "start again with the changed rig"}};
  change(*rig);
  if (const auto written = replace_file_with_backup(file, to_text(*rig)); !written) return {written.error()};
  return {};
}

}  // namespace tactus::app
