#pragma once

#include <optional>

#include "engine/core/error.h"
#include "engine/scene/file/scene_spec.h"
#include "engine/study/walls/virtual_wall.h"

namespace tactus {

/// The device that a scene's plant says it is.
struct SceneDevice {
  WallDevice bare;
  double hand_mass = 0, hand_damping = 0;  ///< of the hand in this scene [kg, N s/m]

  /// Bare and held: masses and dampers add up.
  WallDevice held() const;
};

/// [control] Reads the plant's controls `mass`, `damping`, `friction`, `step` (of its encoder),
/// `force_limit`, `hand_mass` and `hand_damping`, as the scene sets them, else as the plant's file does. All
/// but the first two may be missing. Errors: Missing; WrongType where the scene moves one of them by a
/// gesture or an expression.
Result<SceneDevice> device_of(const SceneSpec& scene);

}  // namespace tactus
