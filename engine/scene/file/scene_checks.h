#pragma once
// Thread: [control]

#include <string>
#include <vector>

#include "engine/graph/file/error_list.h"
#include "engine/scene/build_scene.h"

namespace tactus {

/// Whether the signals, drives, ports and controls that the sections of a scene name exist and have the right
/// units; reported before anything is played.
void check_scene(const SceneSpec& scene, const NodeTable& table, ErrorList& errors);
/// Whether the expected pitch is in Hz. `taps`: the recorded signals of the plant.
void check_expected_pitch(const SceneSpec& scene, const std::vector<SceneTap>& taps, ErrorList& errors);

/// False after an error: "control 'strength' cannot be set to 7 by gesture 'push'; it runs from 0 to 1"
bool check_range(const ControlSpec& control, double value, const Source& at, ErrorList& errors,
                 const std::string& by = {});

}  // namespace tactus
