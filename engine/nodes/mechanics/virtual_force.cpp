#include <algorithm>

#include "engine/nodes/kernel_node.h"
#include "engine/nodes/mechanics/virtual_force_kernel.h"

namespace tactus {
namespace {

struct SpringForce {
  static constexpr int kInputs = 3;
  double value(const double* in) const { return tactus_spring_force(in[0], in[1], in[2]); }
  double slope(int input, const double* in) const {
    const double stiffness = std::max(0.0, in[1]);
    return input == 0 ? -stiffness : input == 1 ? -(in[0] - in[2]) : stiffness;
  }
};

struct DamperForce {
  static constexpr int kInputs = 2;
  double value(const double* in) const { return tactus_damper_force(in[0], in[1]); }
  double slope(int input, const double* in) const { return input == 0 ? -std::max(0.0, in[1]) : -in[0]; }
};

struct WallForce {
  static constexpr int kInputs = 5;  ///< position, velocity, stiffness, damping, at

  double value(const double* in) const { return tactus_wall_force(in[0], in[1], in[2], in[3], in[4]); }
  Lanes value(const Lanes* in) const {
    const auto zero = Lanes::broadcast(0.0);
    const auto push = max(zero, in[2]) * (in[0] - in[4]) + max(zero, in[3]) * in[1];
    return where_above(in[0], in[4], -max(zero, push));
  }
  double slope(int input, const double* in) const {
    const bool touched = in[0] > in[4] && tactus_wall_push(in[0], in[1], in[2], in[3], in[4]) > 0;
    if (!touched) return 0;
    const double stiffness = std::max(0.0, in[2]), damping = std::max(0.0, in[3]);
    const double slopes[kInputs] = {-stiffness, -damping, -(in[0] - in[4]), -in[1], stiffness};
    return slopes[input];
  }
};

}  // namespace

NodeType spring_type() {
  return {
      .name = "spring",
      .summary = "Virtual spring: a force that pulls a device back to its rest position.",
      .equation = "out = -stiffness (in - rest)",
      .source =
          "Berdahl, Steiner & Oldham, NIME 2008, section 6.1.1. Stable on a device with damping b while "
          "stiffness < b / (T / 2 + delay): Gil et al., J. Comput. Inf. Sci. Eng. 9, 2009",
      .example = "pull = { type = \"spring\", in = \"lever\", stiffness = \"200 N/m\" }",
      .inputs = {{"in", "m", "position of the device"},
                 {"stiffness", "N/m", "stiffness (force per displacement)", {}, 0},
                 {"rest", "m", "rest position, where the force is 0", 0}},
      .outputs = {{"out", "N", "force on the device"}},
      .silencers = {{"stiffness"}},
      .settings = {motion_setting()},
      .make = make_elementwise<SpringForce>,
      .stateless = true,
      .range =
          [](int, const NodeSetup& setup) {
            const Interval stiffness = max(setup.input("stiffness").range, Interval::exactly(0));
            return -(stiffness * (setup.input("in").range - setup.input("rest").range));
          },
  };
}

NodeType damper_type() {
  return {
      .name = "damper",
      .summary = "Virtual damper: a force opposite to the velocity of a device.",
      .equation = "out = -damping in",
      .source = "Berdahl, Steiner & Oldham, NIME 2008, section 6.1.1",
      .example = "drag = { type = \"damper\", in = \"speed\", damping = \"0.5 N s/m\" }",
      .inputs = {{"in", "m/s", "velocity of the device"},
                 {"damping", "N s/m", "damping coefficient (force per velocity)", {}, 0}},
      .outputs = {{"out", "N", "force on the device"}},
      .silencers = {{"damping"}},
      .settings = {motion_setting()},
      .make = make_elementwise<DamperForce>,
      .stateless = true,
      .range =
          [](int, const NodeSetup& setup) {
            return -(max(setup.input("damping").range, Interval::exactly(0)) * setup.input("in").range);
          },
  };
}

NodeType wall_type() {
  return {
      .name = "wall",
      .summary = "Virtual wall: beyond `at`, a spring and a damper push the device out; they never pull.",
      .equation = "out = -max(0, stiffness (position - at) + damping velocity) if position > at, else 0",
      .source =
          "Berdahl, Steiner & Oldham, NIME 2008, section 6.1.2. Stable on a device with damping b while "
          "stiffness < (b + damping) / (T / 2 + delay): Gil et al., J. Comput. Inf. Sci. Eng. 9, 2009",
      .example = "stop = { type = \"wall\", position = \"lever\", stiffness = \"800 N/m\", at = \"20 mm\" }",
      .inputs = {{"position", "m", "position of the device"},
                 {"velocity", "m/s", "velocity of the device; needed for the damper", 0},
                 {"stiffness", "N/m", "stiffness (force per depth)", {}, 0},
                 {"damping", "N s/m", "damping coefficient (force per velocity)", 0, 0},
                 {"at", "m", "position of the wall's surface", 0}},
      .outputs = {bounded(-kUnlimited, 0, {"out", "N", "force on the device, never positive"})},
      .settings = {motion_setting()},
      .make = make_elementwise<WallForce>,
      .stateless = true,
  };
}

}  // namespace tactus
