#pragma once

#include "engine/core/error.h"
#include "engine/scene/build_scene.h"
#include "engine/scene/play_scene.h"

namespace tactus {

/// The reference solution, and once more with half the step size: their difference is its own error.
struct ReferenceRun {
  SceneRecording recording, again;
};

/// [control] Plays a plant by the motion of its networks itself (NetworkFlow), from frame to frame and in
/// halves of frames.
Checked<ReferenceRun> play_reference(const SceneSpec& scene, const NodeTable& table, Hertz rate);

/// [any] How, in words.
std::string describe_reference(const SceneSpec& scene);

/// [control] Builds and plays a scene.
Checked<SceneRecording> play_at(const SceneSpec& scene, const NodeTable& table, Hertz rate);

}  // namespace tactus
