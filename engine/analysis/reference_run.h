#pragma once

#include "engine/core/error.h"
#include "engine/scene/build_scene.h"
#include "engine/scene/play_scene.h"

namespace tactus {

/// A scene as it ought to be, and once more by other steps.
struct ReferenceRun {
  SceneRecording recording, again;
  double share = 1;  ///< of their difference that is the error of `recording`
};

/// [control] Plays a plant so closely that solvers can be measured against it: by the motion of its networks
/// itself, where networks know it; else by 64 small passive steps a frame, and again by 32: by Richardson's
/// extrapolation the error of a scheme of second order is a third of what halving its step changes.
Checked<ReferenceRun> play_reference(const SceneSpec& scene, const NodeTable& table, Hertz rate);

/// [any] How, in words.
std::string reference_in_words(const SceneSpec& scene);

/// [control] Builds and plays a scene.
Checked<SceneRecording> play_at(const SceneSpec& scene, const NodeTable& table, Hertz rate);

}  // namespace tactus
