#pragma once

#include "engine/plot/plot.h"
#include "engine/scene/play_scene.h"

namespace tactus {

/// [control] A scene between two times on one time axis: pitch, motion (a subplot for each unit of the
/// plant), sensors with a mark at each trigger, and drives.
Plot scene_plot(const SceneSpec& scene, const SceneRecording& recording, double from_s, double to_s);

}  // namespace tactus
