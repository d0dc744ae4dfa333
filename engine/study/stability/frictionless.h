#pragma once

// Thread: [control].

#include "engine/scene/file/scene_spec.h"

namespace tactus {

/// [control] The same scene with nothing that presses the frictions of its networks: what is left moves by
/// little as its linearisation says.
LoadedScene without_friction(LoadedScene loaded);

}  // namespace tactus
