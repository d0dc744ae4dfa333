#pragma once

#include <cstdint>

#include "engine/graph/plan/fingerprint.h"
#include "engine/scene/file/scene_spec.h"

namespace tactus {

/// [control] Of all that a scene plays: rate, delay, duration, parts with their graphs and wires, gestures,
/// converters, limits of the drives, seed and [playability]. Names, descriptions and file positions do not
/// count.
Fingerprint& add(Fingerprint& print, const SceneSpec& scene);

}  // namespace tactus
