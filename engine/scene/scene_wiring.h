#pragma once

// Thread: [control]

#include <optional>
#include <string>
#include <vector>

#include "engine/core/journal.h"
#include "engine/graph/file/error_list.h"
#include "engine/graph/plan/compile.h"
#include "engine/scene/build_scene.h"

namespace tactus {

/// Whether the signals, drives, ports and controls that the sections of a scene name exist and have the right
/// units; reported before anything is played.
void check_scene(const SceneSpec& scene, const NodeTable& table, ErrorList& errors);
/// Whether the expected pitch is in Hz. `taps`: the recorded signals of the plant.
void check_expected_pitch(const SceneSpec& scene, const std::vector<SceneTap>& taps, ErrorList& errors);

/// A gesture as a node of the graph around the instrument.
NodeSpec gesture_node(const Gesture& gesture);

/// Sets the field `port` to a value from outside, replacing its value in `fields`.
void overwrite(Value::Table& fields, const std::string& port, const ControlValue& value, const Source& at);

/// Where `part` has a control `strike`, its `node` follows one of this name of the `world`, from 0 to 1.
void strike_by_hand(const GraphSpec& part, NodeSpec& node, GraphSpec& world);

/// What a scene does with a control of the instrument: sets its initial value, and may move it.
struct WiredControl {
  double start = 0;                  ///< SI
  const Gesture* gesture = nullptr;  ///< of the scene
};
/// `field` is what the scene writes beside the control. Nothing after an error.
std::optional<WiredControl> wire_control(const SceneSpec& scene, const ControlSpec& entry, const Field& field,
                                         ErrorList& errors);

/// False after an error: "control 'strength' cannot be set to 7; it goes from 0 to 1"
bool check_range(const FlatControl& control, double value, const Source& at, ErrorList& errors);

struct MovedControl {
  std::string control;
  const Gesture* gesture;
};
/// The gestures as changes of controls, in order of time: a step becomes an entry at its frame; a slope
/// becomes one a millisecond (at most 1000000 in all), which the control's own smoothing joins.
std::vector<JournalEntry> gesture_journal(const std::vector<MovedControl>& moved, const Plan& schedule);

}  // namespace tactus
