#include <algorithm>

#include "engine/nodes/kernel_node.h"
#include "engine/nodes/shapers/shaper_kernel.h"

namespace tactus {
namespace {

struct ClipFunction {
  static constexpr int kInputs = 3;
  double value(const double* in) const { return tactus_clip(in[0], in[1], in[2]); }
  Lanes value(const Lanes* in) const { return max(in[1], min(in[2], in[0])); }
  double slope(int input, const double* in) const {
    const int decides = in[1] >= std::min(in[2], in[0]) ? 1 : in[0] > in[2] ? 2 : 0;
    return input == decides ? 1 : 0;
  }
};

}  // namespace

NodeType clip_type() {
  return {
      .name = "clip",
      .summary = "Limits a signal to the range from `low` to `high`.",
      .equation = "out = max(low, min(high, in))",
      .source = "elementary",
      .example = "safe = { type = \"clip\", in = \"force\", low = \"-2 N\", high = \"2 N\" }",
      .inputs = {{"in", "any", "signal"},
                 {"low", "=in", "lower limit; has priority if it is above `high`", -1},
                 {"high", "=in", "largest output", 1}},
      .outputs = {{"out", "=in", "limited signal"}},
      .make = [](const NodeSetup& setup) -> Result<std::unique_ptr<Node>> {
        const auto low = setup.input("low").constant, high = setup.input("high").constant;
        if (low && high && *low > *high)
          return fail(Errc::OutOfRange, {}, "'low' is above 'high', so the output is always 'low'",
                      "exchange them");
        return std::make_unique<ElementwiseNode<ClipFunction>>(ClipFunction{});
      },
      .stateless = true,
      .range =
          [](int, const NodeSetup& setup) {
            return max(setup.input("low").range, min(setup.input("high").range, setup.input("in").range));
          },
  };
}

}  // namespace tactus
