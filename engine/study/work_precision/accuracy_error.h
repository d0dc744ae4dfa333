#pragma once

#include "engine/core/error.h"
#include "engine/scene/file/scene_spec.h"
#include "engine/scene/play_scene.h"

namespace tactus {

/// [control] By how much what `accuracy` names is wrong in `run`, relative (see `accuracy_types`): against
/// what theory says if it says so, else against `reference`, played with the same rate. What ought to
/// oscillate, or to happen, and does not is wrong by 1. Errors: UnknownName if it was not recorded.
Result<double> accuracy_error(const Accuracy& accuracy, const SceneRecording& run,
                              const SceneRecording& reference);

/// [control] Values that are not numbers, or of ten times the size that they may have.
bool exploded(const Accuracy& accuracy, const SceneRecording& run, const SceneRecording& reference);

}  // namespace tactus
