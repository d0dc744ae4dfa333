#pragma once

// Thread: [control].

#include "engine/graph/node_type.h"
#include "engine/nodes/mechanics/arm_kernel.h"

namespace tactus {

/// The ports of an arm, in their order: angles, forces, moments (of an arm with a pen), lengths, masses,
/// stop; the tip, torques, conditioning, at_limit, the orientation of the pen column by column.
struct ArmPorts {
  int axes, joints, lengths;
  int masses = 0;
  bool pen = false;

  constexpr int loads() const { return pen ? axes + 3 : axes; }
  constexpr int sizes() const { return lengths + masses; }
  constexpr int first_size() const { return joints + loads(); }
  constexpr int stop() const { return first_size() + sizes(); }
  constexpr int inputs() const { return stop() + 1; }
  constexpr int conditioning() const { return axes + joints; }
  constexpr int at_limit() const { return conditioning() + 1; }
  constexpr int facing(int column, int axis) const { return at_limit() + 1 + 3 * column + axis; }
  constexpr int outputs() const { return pen ? facing(3, 0) : facing(0, 0); }
};
inline constexpr ArmPorts kTwoLink{.axes = 2, .joints = 2, .lengths = 2};
inline constexpr ArmPorts kFiveBar{.axes = 2, .joints = 2, .lengths = 3};
inline constexpr ArmPorts kDelta{.axes = 3, .joints = 3, .lengths = 3};
inline constexpr ArmPorts kSixAxis{.axes = 3, .joints = 6, .lengths = 3, .masses = 3, .pen = true};

/// The setting `limits` of an arm; without it far beyond any angle. Errors: BadArgument.
Result<tactus_arm_limits> arm_limits(const NodeSetup& setup, int joints);

}  // namespace tactus
