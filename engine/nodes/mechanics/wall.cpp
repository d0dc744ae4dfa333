#include <algorithm>

#include "engine/nodes/elementwise.h"
#include "engine/nodes/mechanics/mechanics.h"
#include "engine/nodes/mechanics/wall_kernel.h"

namespace tactus {
namespace {

struct WallLaw {
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

const NodeType& wall_type() {
  static const NodeType type = {
      .name = "wall",
      .group = "mechanics",
      .summary = "Virtual wall: behind `at` a spring and a damper push the device out; they never pull.",
      .equation = "out = -max(0, stiffness (position - at) + damping velocity) where position > at, else 0",
      .source =
          "Berdahl, Steiner & Oldham, NIME 2008, section 6.1.2. Stable on a device with damping b while "
          "stiffness < "
          "(b + damping) / (T / 2 + delay): Gil et al., J. Comput. Inf. Sci. Eng. 9, 2009",
      .example = "stop = { type = \"wall\", position = \"lever\", stiffness = \"800 N/m\", at = \"20 mm\" }",
      .inputs =
          {{.name = "position", .unit = "m", .doc = "position of the device"},
           {.name = "velocity", .unit = "m/s", .doc = "its velocity; needed for the damper", .fallback = 0},
           {.name = "stiffness", .unit = "N/m", .doc = "force for a metre of depth", .low = 0},
           {.name = "damping", .unit = "N s/m", .doc = "force for a metre a second", .fallback = 0, .low = 0},
           {.name = "at", .unit = "m", .doc = "where the wall begins", .fallback = 0}},
      .outputs = {{.name = "out",
                   .unit = "N",
                   .doc = "force on the device, never positive",
                   .range = {-kUnlimited, 0}}},
      .make = make_elementwise<WallLaw>,
      .stateless = true,
  };
  return type;
}

}  // namespace tactus
