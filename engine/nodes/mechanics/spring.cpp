#include <algorithm>

#include "engine/nodes/kernel_node.h"
#include "engine/nodes/mechanics/spring_kernel.h"

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
      .make = make_elementwise<SpringForce>,
      .stateless = true,
      .range =
          [](int, const NodeSetup& setup) {
            const Interval stiffness = max(setup.input("stiffness").range, Interval::exactly(0));
            return -(stiffness * (setup.input("in").range - setup.input("rest").range));
          },
  };
}

}  // namespace tactus
