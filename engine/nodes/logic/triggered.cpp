#include <cmath>

#include "engine/nodes/kernel_node.h"
#include "engine/nodes/logic/triggered_kernel.h"

namespace tactus {
namespace {

Interval counter_range(int, const NodeSetup& setup) {
  const Interval count = setup.input("count").range;
  return {0, count.low >= 1 ? std::floor(count.high) - 1 : kUnlimited};
}

}  // namespace

NodeType sample_hold_type() {
  return {
      .name = "sample_hold",
      .summary = "Holds the value of its input at the last trigger; 0 before the first trigger.",
      .equation = "out[n] = in[m], m <= n the frame of the last trigger",
      .source = "elementary",
      .example = "velocity = { type = \"sample_hold\", in = \"speed\", trigger = \"hit\" }",
      .inputs = {{"in", "any", "signal"}, sampling({"trigger", "", "trigger that samples the input"})},
      .outputs = {{"out", "=in", "held value"}},
      .silencers = {{"in"}, {"trigger"}},
      .make = make_node<KernelNode<tactus_sample_hold_step, 2>>,
      .small_signal_gain = 1,
      .dead_band = true,
      .range = from_zero_to("in"),
  };
}

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

NodeType toggle_type() {
  return {
      .name = "toggle",
      .summary = "Changes between 0 and 1 at each trigger, as a push switch does; starts at 0.",
      .equation = "out = number of triggers since the last reset, modulo 2",
      .source = "elementary",
      .example = "engaged = { type = \"toggle\", trigger = \"pedal\" }",
      .inputs = {{"trigger", "", "changes the output"},
                 {"reset", "",
                  "trigger that sets the output to 0; has priority over `trigger` in the same frame", 0}},
      .outputs = {bounded(0, 1, {"out", "", "0 or 1"})},
      .silencers = {{"trigger"}},
      .make = make_node<KernelNode<tactus_toggle_step, 2>>,
  };
}

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
