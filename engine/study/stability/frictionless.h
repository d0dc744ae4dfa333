#pragma once

// Thread: [control].

#include "engine/scene/file/scene_spec.h"

namespace tactus {

/// [control] The same scene with nothing that presses the frictions of its networks: its small-signal model
/// is exact for what is left.
LoadedScene without_friction(LoadedScene loaded);

}  // namespace tactus
