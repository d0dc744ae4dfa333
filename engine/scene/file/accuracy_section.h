#pragma once

// Thread: [control]

#include <vector>

#include "engine/graph/file/mistakes.h"
#include "engine/scene/file/scene_spec.h"

namespace tactus {

/// `[accuracy]` of a scene: what of it must come out right.
///   rebound = { measure = "speed", of = "plant.stick", from = "2 ms", to = "3 ms", exact = "1 m/s" }
std::vector<Accuracy> read_accuracy(const Value::Table& scene, Seconds duration, Mistakes& mistakes);

}  // namespace tactus
