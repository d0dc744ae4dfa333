#include "engine/nodes/kernel_node.h"
#include "engine/nodes/shapers/slew_kernel.h"

namespace tactus {

NodeType slew_type() {
  return {
      .name = "slew",
      .summary = "Follows a signal with a limited slew rate, starting at 0.",
      .equation = "out[n] = max(out[n - 1] - fall / rate, min(out[n - 1] + rise / rate, in[n]))",
      .source = "the slew rate of an amplifier, Horowitz & Hill, The Art of Electronics, 3rd ed. 2015",
      .example = "push = { type = \"slew\", in = \"target\", rise = \"20 N/s\", fall = \"5 N/s\" }",
      .inputs = {{"in", "any", "signal"},
                 {"rise", "=in/s", "largest rate of increase", {}, 0},
                 {"fall", "=in/s", "largest rate of decrease", {}, 0}},
      .outputs = {{"out", "=in", "slew-limited signal"}},
      .silencers = {{"in"}},
      .make = make_node<KernelNode<tactus_slew_step, 3, frame_s_of>>,
      .small_signal_gain = 1,
      .range = from_zero_to("in"),
  };
}

}  // namespace tactus
