#pragma once

// Thread: [control]

#include <optional>
#include <string>
#include <vector>

#include "engine/graph/file/mistakes.h"
#include "engine/scene/file/scene_spec.h"

namespace tactus {

/// `[playability]` of a scene: what playing it well means; nothing if it says nothing.
///   kind = "roll", fewest = 12
///   kind = "tone", pitch = "110 Hz", begin = "0.1 s"
///   kind = "tone", pitch = "wanted.pitch": as many notes as that signal has
std::optional<Playability> read_playability(const Value::Table& scene, Seconds duration,
                                            const std::vector<Role>& roles, Mistakes& mistakes);

}  // namespace tactus
