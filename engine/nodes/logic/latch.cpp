#include "engine/nodes/kernel_node.h"
#include "engine/nodes/logic/latch_kernel.h"

namespace tactus {

NodeType latch_type() {
  return {
      .name = "latch",
      .summary =
          "Set to 1 by one trigger and reset to 0 by another; the reset has priority in the same frame.",
      .equation = "out = 1 from a trigger at `set` until one at `reset`",
      .source = "elementary",
      .example = "playing = { type = \"latch\", set = \"start\", reset = \"stop\" }",
      .inputs = {{"set", "", "trigger that sets the output to 1"},
                 {"reset", "", "trigger that resets the output to 0", 0}},
      .outputs = {bounded(0, 1, {"out", "", "0 or 1"})},
      .make = make_node<KernelNode<tactus_latch_step, 2>>,
  };
}

}  // namespace tactus
