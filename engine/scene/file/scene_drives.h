#pragma once

// Thread: [control]

#include <filesystem>

#include "engine/graph/file/mistakes.h"
#include "engine/scene/file/scene_spec.h"

namespace tactus {

/// `[drives]` of a scene: what stands behind the instrument's drives. `folder` is the scene's, `root` the one
/// with the profiles.
///   woofer = { profile = "woofer", volts_per_full_scale = "10 V", ceiling = 0.8 }
/// Without a profile the limits are the cautious ones. A ceiling may be lower than it is anyway, never
/// higher.
void read_drives(const Value::Table& scene, const std::filesystem::path& folder,
                 const std::filesystem::path& root, SceneSpec& spec, Mistakes& mistakes);

/// Does the instrument have these drives?
void check_drives(const SceneSpec& scene, Mistakes& mistakes);

}  // namespace tactus
