#include "apps/actuators/actuator_files.h"

#include <algorithm>
#include <set>

#include "apps/cli/rig_files.h"
#include "apps/cli/target.h"

namespace tactus::app {
namespace {

namespace fs = std::filesystem;

std::vector<fs::path> figure_files() {
  std::vector<fs::path> all;
  std::set<std::string> names;
  for (const auto& folder : instrument_folders()) {
    std::error_code none;
    std::vector<fs::path> files;
    for (const auto& entry : fs::directory_iterator{folder / "actuators" / "figures", none})
      if (entry.path().extension() == ".toml") files.push_back(entry.path());
    std::ranges::sort(files);
    for (const auto& file : files)
      if (names.insert(file.stem().generic_string()).second) all.push_back(file);
  }
  return all;
}

Checked<ActuatorProfile> named_profile(const ActuatorFigures& figures, const fs::path& file) {
  const auto& name = figures.profile;
  if (name.ends_with(".toml")) return load_profile(file.parent_path() / name);
  const auto found = find_profile(name, option_profile_folders(), figures.profile_at.text());
  if (!found) return tl::unexpected(std::vector{found.error()});
  return load_profile(*found);
}

Checked<Actuator> load_actuator(const fs::path& file) {
  auto figures = load_actuator_figures(file);
  if (!figures) return tl::unexpected(figures.error());
  Actuator actuator{std::move(*figures), file, std::nullopt};
  if (actuator.figures.profile.empty()) return actuator;
  auto profile = named_profile(actuator.figures, file);
  if (!profile) return tl::unexpected(profile.error());
  actuator.profile = std::move(*profile);
  return actuator;
}

/// The shipped files come last: they keep their names.
void remove_same_name(const Actuator& actuator, ActuatorFiles& all) {
  const auto& name = actuator.figures.name;
  const auto same =
      std::ranges::find_if(all.actuators, [&](const Actuator& other) { return other.figures.name == name; });
  if (same == all.actuators.end()) return;
  all.errors.push_back({Errc::Duplicate, same->figures.name_at.text(),
                        "'" + name + "' is the name of the actuator in " + actuator.file.generic_string(),
                        "give it another name, or call this file " +
                            actuator.file.filename().generic_string() + " to replace that one"});
  all.actuators.erase(same);
}

}  // namespace

ActuatorFiles load_actuators() {
  ActuatorFiles all;
  for (const auto& file : figure_files()) {
    auto actuator = load_actuator(file);
    if (!actuator) {
      all.errors.insert(all.errors.end(), actuator.error().begin(), actuator.error().end());
      continue;
    }
    remove_same_name(*actuator, all);
    all.actuators.push_back(std::move(*actuator));
  }
  return all;
}

}  // namespace tactus::app
