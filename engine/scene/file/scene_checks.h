#pragma once

// Thread: [control]

#include <vector>

#include "engine/graph/file/error_list.h"
#include "engine/graph/node_type.h"
#include "engine/scene/build_scene.h"
#include "engine/scene/file/scene_spec.h"

namespace tactus {

/// Whether the signals, drives, ports and controls that the sections of a scene name exist and have the right
/// units; reported before anything is played.
void check_scene(const SceneSpec& scene, const NodeTable& table, ErrorList& errors);
/// Whether the expected pitch is in Hz. `taps`: the recorded signals of the plant.
void check_expected_pitch(const SceneSpec& scene, const std::vector<SceneTap>& taps, ErrorList& errors);

}  // namespace tactus
