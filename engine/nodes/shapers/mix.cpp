#include "engine/nodes/elementwise.h"
#include "engine/nodes/shapers/shapers.h"

namespace tactus {
namespace {

struct Copy {
  static constexpr int kInputs = 1;
  double value(const double* in) const { return in[0]; }
  double slope(int, const double*) const { return 1; }
};

}  // namespace

const NodeType& mix_type() {
  static const NodeType type = {
      .name = "mix",
      .group = "shapers",
      .summary = "Adds all lanes of a signal into one.",
      .equation =
          "out = sum of in over its lanes; lane k takes in lanes k + 8, k + 16, ..., then what is left is\n"
          "added in halves: k and k + 4, k and k + 2, k and k + 1",
      .source = "elementary",
      .example = "sum = { type = \"mix\", in = \"voices\" }",
      .inputs = {{.name = "in", .unit = "any", .doc = "signal of any number of lanes"}},
      .outputs = {{.name = "out", .unit = "=in", .doc = "sum, one lane"}},
      .make = make_elementwise<Copy>,
      .stateless = true,
      .reduces_lanes = true,
  };
  return type;
}

}  // namespace tactus
