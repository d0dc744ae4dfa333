#include "engine/nodes/kernel_node.h"
#include "engine/nodes/logic/latch_kernel.h"

namespace tactus {

NodeType latch_type() {
  return {
      .name = "latch",
      .summary = "Goes to 1 at one trigger and back to 0 at another, which wins if both come in one frame.",
      .equation = "out = 1 from a trigger at `set` until one at `reset`",
      .source = "elementary",
      .example = "playing = { type = \"latch\", set = \"start\", reset = \"stop\" }",
      .inputs = {{"set", "", "trigger that switches on"}, {"reset", "", "trigger that switches off", 0}},
      .outputs = {bounded(0, 1, {"out", "", "0 or 1"})},
      .make = make_node<KernelNode<tactus_latch_step, 2>>,
  };
}

}  // namespace tactus
