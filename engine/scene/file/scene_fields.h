#pragma once

#include "engine/graph/file/field.h"

// Thread: [any]

namespace tactus {

/// All keys of a scene.
const SectionType& scene_fields();

}  // namespace tactus
