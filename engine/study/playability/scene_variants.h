#pragma once

#include <cstdint>
#include <string>

#include "engine/scene/file/scene_spec.h"

namespace tactus {

/// [control] The scene with an actuator that is `gain` times as strong: what the instrument gives out reaches
/// every other part times that.
SceneSpec with_actuator_gain(SceneSpec scene, double gain);

/// [control] The scene with another sample of its plant: every quantity of every network of every part but
/// the instrument (masses, stiffnesses, dampings, losses, coils, friction) times 1 + within u, u uniform from
/// -1 to 1 and each its own, from `seed` and the name of the quantity. Places, exponents and what moves by
/// itself stay.
SceneSpec with_plant_drawn(SceneSpec scene, double within, std::uint64_t seed);

/// [control] The scene with all values of a gesture times `factor`. The gesture must be there.
SceneSpec with_gesture_scaled(SceneSpec scene, const std::string& gesture, double factor);

/// [control] The scene with a gesture that stays at one value [SI] from start to end. It must be there.
SceneSpec with_gesture_held(SceneSpec scene, const std::string& gesture, double value);

}  // namespace tactus
