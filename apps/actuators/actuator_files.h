#pragma once
// Thread: [control]

#include <filesystem>
#include <optional>
#include <vector>

#include "engine/core/error.h"
#include "engine/rig/actuator_figures.h"
#include "engine/rig/profile.h"

namespace tactus::app {

/// An actuator of the list, and the profile that its file names.
struct Actuator {
  ActuatorFigures figures;
  std::filesystem::path file;
  std::optional<ActuatorProfile> profile;
};

/// Those of the files in `actuators/figures` of every folder of instruments; a file of the same name in an
/// earlier folder goes first. What is wrong with a file leaves out its actuator alone.
struct ActuatorFiles {
  std::vector<Actuator> actuators;
  std::vector<Error> errors;
};
ActuatorFiles load_actuators();

}  // namespace tactus::app
