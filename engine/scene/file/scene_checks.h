#pragma once

// Thread: [control]

#include <string_view>
#include <vector>

#include "engine/graph/file/error_list.h"
#include "engine/graph/node_type.h"
#include "engine/scene/build_scene.h"
#include "engine/scene/file/scene_spec.h"

namespace tactus {

/// The entry called `name`, or nullptr.
const EntrySpec* find_entry(const std::vector<EntrySpec>& entries, std::string_view name);

/// [expect]: is there such a measure, and will what it is taken of be recorded? Told before anything is
/// played.
void check_measures(const SceneSpec& scene, const NodeTable& table, ErrorList& mistakes);

/// [accuracy]: will what it compares be recorded, and are its numbers in the right unit?
void check_accuracy(const SceneSpec& scene, const NodeTable& table, ErrorList& mistakes);

/// [playability]: will what it listens to be recorded?
void check_playability(const SceneSpec& scene, const NodeTable& table, ErrorList& mistakes);
/// Is the pitch that it wants one? `taps`: what the world gives out.
void check_expected_pitch(const SceneSpec& scene, const std::vector<SceneTap>& taps, ErrorList& mistakes);

/// [drives]: does the instrument have them?
void check_drives(const SceneSpec& scene, ErrorList& mistakes);

/// [ports]: are its signals outputs of parts other than the instrument, and is force times way an energy?
void check_ports(const SceneSpec& scene, ErrorList& mistakes);

/// [compare]: is there what it sets?
void check_comparison(const SceneSpec& scene, ErrorList& mistakes);

}  // namespace tactus
