#pragma once
// Thread: [any]

#include <functional>
#include <string>

#include "apps/cli/target.h"
#include "engine/scene/build_scene.h"

namespace tactus::app {

struct WorldVerdict {
  bool stable = false;
  std::string text;  ///< "stable", "unstable; …"
};

/// Whether a simulated world is stable, as `tactus check` says it: of the files as they are now. Takes
/// seconds on this thread. `go_on` is asked again and again: false ends it without a verdict.
WorldVerdict judge_world(const Target& target, const std::string& inputs, const SceneOptions& options,
                         const std::function<bool()>& go_on);

}  // namespace tactus::app
