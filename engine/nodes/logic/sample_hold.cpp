#include "engine/nodes/kernel_node.h"
#include "engine/nodes/logic/sample_hold_kernel.h"

namespace tactus {

NodeType sample_hold_type() {
  return {
      .name = "sample_hold",
      .summary = "Holds the value of its input at the last trigger; 0 before the first trigger.",
      .equation = "out[n] = in[m], m <= n the frame of the last trigger",
      .source = "elementary",
      .example = "velocity = { type = \"sample_hold\", in = \"speed\", trigger = \"hit\" }",
      .inputs = {{"in", "any", "signal"}, {"trigger", "", "trigger that samples the input"}},
      .outputs = {{"out", "=in", "held value"}},
      .make = make_node<KernelNode<tactus_sample_hold_step, 2>>,
      .small_signal_gain = 1,
      .range = from_zero_to("in"),
  };
}

}  // namespace tactus
