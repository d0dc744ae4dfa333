#include "engine/nodes/kernel_node.h"
#include "engine/nodes/shapers/shaper_kernel.h"

namespace tactus {

NodeType hysteresis_type() {
  return {
      .name = "hysteresis",
      .summary = "Backlash: the output follows the input with a dead band of `width`.",
      .equation = "out[n] = max(in[n] - width / 2, min(in[n] + width / 2, out[n - 1])), starting at 0",
      .source = "play operator: Krasnosel'skii & Pokrovskii, Systems with Hysteresis, 1989",
      .example = "steady = { type = \"hysteresis\", in = \"lever\", width = \"0.2 mm\" }",
      .inputs = {{"in", "any", "signal"}, {"width", "=in", "width of the dead band", {}, 0}},
      .outputs = {{"out", "=in", "input with variations smaller than the width removed"}},
      .silencers = {{"in"}},
      .make = make_node<KernelNode<tactus_hysteresis_step, 2>>,
      .small_signal_gain = 1,
      .dead_band = true,
      .range = from_zero_to("in"),
  };
}

}  // namespace tactus
