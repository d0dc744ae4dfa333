#pragma once

// Thread: [control]

#include "engine/graph/file/mistakes.h"
#include "engine/scene/file/scene_spec.h"

namespace tactus {

/// `[ports]` of a scene: where a motor of the instrument moves the plant, and how much energy it may give.
///   arm = { force = "plant.motor", position = "plant.arm", active_up_to = "20 mJ" }
std::vector<Port> read_ports(const Value::Table& scene, Mistakes& mistakes);

/// Are its signals outputs of parts other than the instrument, and is force times way an energy?
void check_ports(const SceneSpec& scene, Mistakes& mistakes);

}  // namespace tactus
