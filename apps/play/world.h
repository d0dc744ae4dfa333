#pragma once
// Thread: [control]

#include <string>

#include "apps/cli/target.h"
#include "apps/play/play_report.h"
#include "engine/scene/file/scene_spec.h"

namespace tactus::app {

/// What a simulation plays.
struct World {
  LoadedScene loaded;
  std::string inputs{};  ///< of an instrument without a plant: what its inputs receive, a line each
};

/// A scene; or an instrument, whose inputs receive what `inputs` (--in) names: "test-signal" (also ""),
/// "silence", "keyboard" or a sound file, whose rate and duration are then the defaults. `by_hand`: somebody
/// can press keys. Throws a CommandError with the errors of an instrument; BadArgument for `inputs`.
World load_world(const Target& target, const std::string& inputs, bool by_hand);

}  // namespace tactus::app
