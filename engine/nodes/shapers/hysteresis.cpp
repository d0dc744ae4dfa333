#include <algorithm>

#include "engine/nodes/make.h"
#include "engine/nodes/shapers/hysteresis_kernel.h"
#include "engine/nodes/shapers/shapers.h"

namespace tactus {
namespace {

struct Hysteresis {
  static constexpr int kInputs = 2;
  explicit Hysteresis(const NodeSetup&) {}
  double step(const double* in) { return tactus_hysteresis_step(&state, in[0], in[1]); }

  tactus_hysteresis state{};
};

}  // namespace

const NodeType& hysteresis_type() {
  static const NodeType type = {
      .name = "hysteresis",
      .group = "shapers",
      .summary = "Backlash: the output follows its input only when pushed by one of two ends `width` apart.",
      .equation = "out[n] = max(in[n] - width / 2, min(in[n] + width / 2, out[n - 1])), from 0 on",
      .source = "play operator: Krasnosel'skii & Pokrovskii, Systems with Hysteresis, 1989",
      .example = "steady = { type = \"hysteresis\", in = \"lever\", width = \"0.2 mm\" }",
      .inputs = {{.name = "in", .unit = "any", .doc = "signal"},
                 {.name = "width", .unit = "=in", .doc = "distance of the two ends", .low = 0}},
      .outputs = {{.name = "out", .unit = "=in", .doc = "signal without movements smaller than the width"}},
      .make = make_node<KernelNode<Hysteresis>>,
      .small_signal_gain = 1,
      // It starts at 0 and is pushed no further than the input goes.
      .range =
          [](int, const NodeSetup& setup) {
            const auto in = setup.input("in").range;
            return Interval{std::min(0.0, in.low), std::max(0.0, in.high)};
          },
  };
  return type;
}

}  // namespace tactus
