#pragma once

#include "engine/graph/file/field.h"

// Thread: [any]

namespace tactus {

/// All keys of a scene.
const SectionType& scene_fields();

/// Of an entry of [gestures], [drives], [ports], [expect] and [accuracy]; of [converters] and [playability].
const SectionType& gesture_fields();
const SectionType& drive_fields();
const SectionType& port_fields();
const SectionType& expectation_fields();
const SectionType& accuracy_fields();
const SectionType& converter_fields();
const SectionType& playability_fields();
const SectionType& role_fields();

}  // namespace tactus
