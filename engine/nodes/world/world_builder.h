#pragma once

// Thread: [control]
#include <string>
#include <string_view>
#include <vector>

#include "engine/graph/node_type.h"
#include "engine/nodes/world/rigid_bodies.h"
#include "engine/nodes/world/world_layout.h"

namespace tactus {

/// A number of a body or a handle that may change: an input of the node, or a constant.
struct WorldInput {
  int port = -1;
  double value = 0;  ///< where there is no port
};

/// Where the node reads what a body is and where it is put.
struct WorldBodyInputs {
  WorldShape shape = WorldShape::Sphere;
  std::array<WorldInput, 3> place, velocity, force, size;
  WorldInput mass, density;
  bool by_density = false;
  WorldInput put, launch, present;

  /// Volume of a body of this size, m^3.
  double volume(const std::array<double, 3>& size) const;
};

/// Axes that are not given have no port, and no force.
struct WorldHandle {
  int body = 0;
  std::array<WorldInput, 3> position;
  std::array<bool, 3> given{};
  double stiffness = 0, damping = 0, passivity = 0;
  WorldInput holds;  ///< number of a body in the file; 0: none; below: `body`
};

/// A joint that is made while the world runs.
struct WorldLink {
  int joint = 0;
  WorldInput kind, first, second;  ///< number in kJointNames from 1; numbers of bodies in the file
  std::array<WorldInput, 3> anchor, axis, second_axis;
  WorldInput attach, stiffness, damping, effort, second_effort;
};

struct WorldDrive {
  int joint = 0;
  WorldInput effort;
};

/// Impacts of the body `on` against `against`, or against any.
struct WorldImpacts {
  int on = 0, against = -1;
  double least_speed = 0;
};

/// What one output of the node shows: quantity `quantity` of the part `part` of that kind, or, without an
/// element, of the world.
struct WorldOutput {
  const WorldElementType* type = nullptr;
  int part = -1;  ///< -1: left out, which is 0
  int quantity = 0;
  WorldReading reading = WorldReading::Held;
};

/// All that a running world is made from, without what matters to no output that is read.
struct WorldRecipe {
  RigidModel model;
  int frames = 1;  ///< of a step
  std::vector<WorldBodyInputs> bodies;
  std::vector<WorldHandle> handles;
  std::vector<WorldLink> links;
  std::vector<WorldDrive> drives;
  std::vector<WorldImpacts> impacts;
  std::array<WorldInput, 3> gravity;
  std::vector<int> by_number;  ///< bodies by their number in the file less 1; -1: left out
  BodyLooks looks;
  std::vector<WorldOutput> outputs;  ///< in the order of the declaration
  std::vector<bool> needed;          ///< inputs that something reads, in the order of the declaration
  std::vector<LeftOut> left_out;
  std::uint64_t variant = 0;  ///< distinguishes what has been left out; 0: nothing
};

WorldRecipe build_world(const WorldLayout& layout, const NodeSetup& setup);

}  // namespace tactus
