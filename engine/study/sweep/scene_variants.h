#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "engine/graph/plan/compile.h"
#include "engine/graph/plan/fingerprint.h"
#include "engine/scene/file/scene_spec.h"

// Thread: [control]

namespace tactus {

/// A change of a network. `path` leads to it through the parts: "plant.drum".
using NetworkChange = std::function<void(NetworkSpec& network, const std::string& path)>;
/// A scene with every network changed, those of parts of parts too, and those of the instrument or not.
/// Graphs are copied, since other scenes may share them.
SceneSpec with_networks_changed(SceneSpec scene, const NetworkChange& change, bool instrument);

/// A scene with an actuator that is `gain` times as strong: the outputs of the instrument reach every other
/// part times that.
SceneSpec with_actuator_gain(SceneSpec scene, double gain);

/// A scene with a random variation of its plant: every quantity of every network of every part but the
/// instrument (masses, stiffnesses, dampings, losses, coils, friction) times 1 + within u, u uniform from -1
/// to 1 and each its own, from `seed` and the name of the quantity. Positions, exponents and signals stay.
SceneSpec with_plant_drawn(SceneSpec scene, double within, std::uint64_t seed);

/// A scene with all values of a gesture times `factor`. The gesture must be there.
SceneSpec with_gesture_scaled(SceneSpec scene, const std::string& gesture, double factor);
/// A scene with a gesture that stays at one value [SI] from start to end. It must be there.
SceneSpec with_gesture_held(SceneSpec scene, const std::string& gesture, double value);

/// All fields of nodes and network elements that are numbers or quantities: "plant.drum.coil.resistance".
std::vector<std::string> constant_names(const SceneSpec& scene);
/// A scene with another value for one of them. A part that is used twice is changed in one place only.
SceneSpec with_constant(SceneSpec scene, const std::string& name, const ControlValue& value);

/// A scene with an option of every network of every part but the instrument: "solver", "oversample".
SceneSpec with_network_option(SceneSpec scene, const std::string& key, decltype(Value::data) value);
/// The names of `solver` that step a network: all but the automatic choice and the reference.
std::vector<std::string> stepping_solvers();
/// The networks of the plant have only linear links: no contact, no friction.
bool is_linear(const SceneSpec& scene);
/// The plant has a network.
bool has_network(const SceneSpec& scene);

/// Adds all that a scene plays: rate, delay, duration, parts with their graphs and wires, gestures,
/// converters, limits of the drives, seed and [playability]; not names, descriptions and file positions.
Fingerprint& add(Fingerprint& print, const SceneSpec& scene);

}  // namespace tactus
