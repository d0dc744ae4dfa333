#include <algorithm>

#include "engine/nodes/kernel_node.h"
#include "engine/nodes/mechanics/damper_kernel.h"

namespace tactus {
namespace {

struct DamperForce {
  static constexpr int kInputs = 2;
  double value(const double* in) const { return tactus_damper_force(in[0], in[1]); }
  double slope(int input, const double* in) const { return input == 0 ? -std::max(0.0, in[1]) : -in[0]; }
};

}  // namespace

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
      .make = make_elementwise<DamperForce>,
      .stateless = true,
      .range =
          [](int, const NodeSetup& setup) {
            return -(max(setup.input("damping").range, Interval::exactly(0)) * setup.input("in").range);
          },
  };
}

}  // namespace tactus
