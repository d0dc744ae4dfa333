#include "engine/nodes/shapers/mix.h"

#include "engine/nodes/elementwise.h"

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
      .inputs = {{.name = "in", .unit = "any", .doc = "signal of any number of lanes", .fallback = {}}},
      .outputs = {{.name = "out", .unit = "=in", .doc = "sum, one lane", .range = {}}},
      .settings = {},
      .make = [](const NodeSetup&) -> Result<std::unique_ptr<Node>> {
        return std::make_unique<ElementwiseNode<Copy>>(Copy{});
      },
      .stateless = true,
      .reduces_lanes = true,
      .range = {},
  };
  return type;
}

}  // namespace tactus
