#include <cmath>

#include "engine/nodes/logic/counter_kernel.h"
#include "engine/nodes/logic/logic.h"
#include "engine/nodes/make.h"

namespace tactus {
namespace {

struct Counter {
  static constexpr int kInputs = 3;
  explicit Counter(const NodeSetup&) {}
  double step(const double* in) { return tactus_counter_step(&state, in[0], in[1], in[2]); }

  tactus_counter state{};
};

Interval range(int, const NodeSetup& setup) {
  const Interval count = setup.input("count").range;
  return {0, count.low >= 1 ? std::floor(count.high) - 1 : kUnlimited};
}

}  // namespace

const NodeType& counter_type() {
  static const NodeType type = {
      .name = "counter",
      .group = "logic",
      .summary = "Counts triggers from 0, and starts over when it reaches `count`.",
      .equation = "out = number of triggers since the last reset, modulo floor(count)",
      .source = "elementary",
      .example = "step = { type = \"counter\", trigger = \"hit\", count = 4 }",
      .inputs =
          {{.name = "trigger", .unit = "", .doc = "counts one up in its own frame"},
           {.name = "reset",
            .unit = "",
            .doc = "trigger that goes back to 0; wins in a frame with `trigger`",
            .fallback = 0},
           {.name = "count", .unit = "", .doc = "starts over here; below 1: never", .fallback = 0, .low = 0}},
      .outputs = {{.name = "out", .unit = "", .doc = "whole number from 0 on", .range = {0, kUnlimited}}},
      .make = make_node<KernelNode<Counter>>,
      .range = range,
  };
  return type;
}

}  // namespace tactus
