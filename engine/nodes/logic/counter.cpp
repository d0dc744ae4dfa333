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
      .summary = "Counts triggers from 0, and starts over when it reaches `count`.",
      .equation = "out = number of triggers since the last reset, modulo floor(count)",
      .source = "elementary",
      .example = "step = { type = \"counter\", trigger = \"hit\", count = 4 }",
      .inputs = {{"trigger", "", "counts one up in its own frame"},
                 {"reset", "", "trigger that goes back to 0; wins in a frame with `trigger`", 0},
                 {"count", "", "starts over here; below 1: never", 0, 0}},
      .outputs = {bounded(0, kUnlimited, {"out", "", "whole number from 0 on"})},
      .make = make_node<KernelNode<tactus_counter_step, 3>>,
      .range = counter_range,
  };
}

}  // namespace tactus
