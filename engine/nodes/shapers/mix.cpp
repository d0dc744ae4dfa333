#include "engine/nodes/kernel_node.h"
#include "engine/nodes/shapers/shaper_kernel.h"

namespace tactus {
namespace {

struct MixFunction {
  static constexpr int kInputs = 1;
  double value(const double* in) const {
    double lane = in[0];
    return tactus_mix(&lane, 1);
  }
  double slope(int, const double*) const { return 1; }
};

}  // namespace

NodeType mix_type() {
  return {
      .name = "mix",
      .summary = "Sums all lanes (parallel signals) of a signal.",
      .equation =
          "out = sum of in over its lanes; lanes k + 8, k + 16, ... are added to lane k, then the remaining "
          "8 lanes\nin halves: k and k + 4, k and k + 2, k and k + 1",
      .source = "elementary",
      .example = "sum = { type = \"mix\", in = \"voices\" }",
      .inputs = {{"in", "any", "signal of any number of lanes"}},
      .outputs = {{"out", "=in", "sum, one lane"}},
      .make = make_elementwise<MixFunction>,
      .stateless = true,
      .reduces_lanes = true,
  };
}

}  // namespace tactus
