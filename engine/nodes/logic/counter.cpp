#include <cmath>

#include "engine/nodes/kernel_node.h"
#include "engine/nodes/logic/counter_kernel.h"

namespace tactus {
namespace {

Interval counter_range(int, const NodeSetup& setup) {
  const Interval count = setup.input("count").range;
  return {0, count.low >= 1 ? std::floor(count.high) - 1 : kUnlimited};
}

}  // namespace

NodeType counter_type() {
  return {
      .name = "counter",
      .summary = "Counts triggers from 0 and wraps to 0 when it reaches `count`.",
      .equation = "out = number of triggers since the last reset, modulo floor(count)",
      .source = "elementary",
      .example = "step = { type = \"counter\", trigger = \"hit\", count = 4 }",
      .inputs = {{"trigger", "", "increments the count in the frame of the trigger"},
                 {"reset", "",
                  "trigger that resets the count to 0; has priority over `trigger` in the same frame", 0},
                 {"count", "", "count at which it wraps to 0; below 1: never", 0, 0}},
      .outputs = {bounded(0, kUnlimited, {"out", "", "the count, a whole number from 0"})},
      .make = make_node<KernelNode<tactus_counter_step, 3>>,
      .range = counter_range,
  };
}

}  // namespace tactus
