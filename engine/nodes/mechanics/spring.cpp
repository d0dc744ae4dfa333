#include <algorithm>

#include "engine/nodes/elementwise.h"
#include "engine/nodes/mechanics/mechanics.h"
#include "engine/nodes/mechanics/spring_kernel.h"

namespace tactus {
namespace {

struct Spring {
  static constexpr int kInputs = 3;
  double value(const double* in) const { return tactus_spring_force(in[0], in[1], in[2]); }
  double slope(int input, const double* in) const {
    const double stiffness = std::max(0.0, in[1]);
    return input == 0 ? -stiffness : input == 1 ? -(in[0] - in[2]) : stiffness;
  }
};

}  // namespace

const NodeType& spring_type() {
  static const NodeType type = {
      .name = "spring",
      .group = "mechanics",
      .summary = "Virtual spring: the force that pulls a device back to its rest position.",
      .equation = "out = -stiffness (in - rest)",
      .source =
          "Berdahl, Steiner & Oldham, NIME 2008, section 6.1.1. Stable on a device with damping b while "
          "stiffness < "
          "b / (T / 2 + delay): Gil et al., J. Comput. Inf. Sci. Eng. 9, 2009",
      .example = "pull = { type = \"spring\", in = \"lever\", stiffness = \"200 N/m\" }",
      .inputs = {{.name = "in", .unit = "m", .doc = "position of the device"},
                 {.name = "stiffness", .unit = "N/m", .doc = "force for a metre", .low = 0},
                 {.name = "rest", .unit = "m", .doc = "position without force", .fallback = 0}},
      .outputs = {{.name = "out", .unit = "N", .doc = "force on the device"}},
      .make = make_elementwise<Spring>,
      .stateless = true,
      .range =
          [](int, const NodeSetup& setup) {
            const Interval stiffness = max(setup.input("stiffness").range, Interval::exactly(0));
            return -(stiffness * (setup.input("in").range - setup.input("rest").range));
          },
  };
  return type;
}

}  // namespace tactus
