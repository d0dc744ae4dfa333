#pragma once

#include <functional>
#include <string>

#include "engine/scene/file/scene_spec.h"

namespace tactus {

/// What is done to a network. `path` leads to it through the parts: "plant.drum".
using NetworkChange = std::function<void(NetworkSpec& network, const std::string& path)>;

/// [control] A scene of which each network was changed, those of parts of parts too. Graphs are copied, since
/// other scenes may share them.
SceneSpec with_networks_changed(SceneSpec scene, const NetworkChange& change);
/// The same of all parts but the instrument.
SceneSpec with_world_changed(SceneSpec scene, const NetworkChange& change);

}  // namespace tactus
