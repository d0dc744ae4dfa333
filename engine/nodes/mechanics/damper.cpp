#include <algorithm>

#include "engine/nodes/elementwise.h"
#include "engine/nodes/mechanics/damper_kernel.h"
#include "engine/nodes/mechanics/mechanics.h"

namespace tactus {
namespace {

struct Damper {
  static constexpr int kInputs = 2;
  double value(const double* in) const { return tactus_damper_force(in[0], in[1]); }
  double slope(int input, const double* in) const { return input == 0 ? -std::max(0.0, in[1]) : -in[0]; }
};

}  // namespace

const NodeType& damper_type() {
  static const NodeType type = {
      .name = "damper",
      .group = "mechanics",
      .summary = "Virtual damper: a force against the velocity of a device.",
      .equation = "out = -damping in",
      .source = "Berdahl, Steiner & Oldham, NIME 2008, section 6.1.1",
      .example = "drag = { type = \"damper\", in = \"speed\", damping = \"0.5 N s/m\" }",
      .inputs = {{.name = "in", .unit = "m/s", .doc = "velocity of the device"},
                 {.name = "damping", .unit = "N s/m", .doc = "force for a metre a second", .low = 0}},
      .outputs = {{.name = "out", .unit = "N", .doc = "force on the device"}},
      .make = make_elementwise<Damper>,
      .stateless = true,
      .range =
          [](int, const NodeSetup& setup) {
            return -(max(setup.input("damping").range, Interval::exactly(0)) * setup.input("in").range);
          },
  };
  return type;
}

}  // namespace tactus
