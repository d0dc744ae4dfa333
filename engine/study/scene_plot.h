#pragma once

#include "engine/plot/svg.h"
#include "engine/scene/play_scene.h"

namespace tactus {

/// [any] What happened in a scene between two times, on one time axis: what moved (a panel for each unit of
/// the plant), what the instrument heard, with a mark at each trigger, and what it gave out.
Figure story(const SceneSpec& scene, const SceneRecording& recording, double from_s, double to_s);

}  // namespace tactus
