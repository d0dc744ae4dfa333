#pragma once

// Thread: [control]

#include <optional>
#include <string>
#include <vector>

#include "engine/core/journal.h"
#include "engine/graph/file/error_list.h"
#include "engine/graph/plan/plan.h"
#include "engine/scene/file/scene_spec.h"

namespace tactus {

/// What a scene does with a control of the instrument: sets where it starts, and may move it.
struct WiredControl {
  double start = 0;                  ///< SI
  const Gesture* gesture = nullptr;  ///< of the scene
};
/// `field` is what the scene writes beside the control. Nothing after a mistake.
std::optional<WiredControl> wire_control(const SceneSpec& scene, const EntrySpec& control, const Field& field,
                                         ErrorList& mistakes);

/// "control 'strength' cannot be set to 7; it goes from 0 to 1"
void complain_range(const FlatControl& control, double value, const Source& at, ErrorList& mistakes);

struct MovedControl {
  std::string control;
  const Gesture* gesture;
};
/// The gestures as changes of controls, in order of time: a step becomes an entry at its frame; a slope
/// becomes one a millisecond (at most 1000000 in all), which the control's own smoothing joins.
std::vector<JournalEntry> gesture_journal(const std::vector<MovedControl>& moved, const Plan& schedule);

}  // namespace tactus
