#include <cmath>

#include "engine/dsp/envelopes/rise.h"
#include "engine/nodes/logic/logic.h"
#include "engine/nodes/make.h"

namespace tactus {
namespace {

class Counter final : public Node {
 public:
  explicit Counter(const NodeSetup&) {}

  void process(const NodeBlock& block) noexcept override {
    const Signal trigger = block.in[0], reset = block.in[1], count = block.in[2];
    for (int i = 0; i < block.frames; ++i) {
      if (trigger_.step(trigger[i])) {
        ++counted_;
        if (count[i] >= 1 && counted_ >= std::floor(count[i])) counted_ = 0;
      }
      if (reset_.step(reset[i])) counted_ = 0;
      block.out[0][i] = counted_;
    }
  }
  void reset() noexcept override {
    trigger_ = {};
    reset_ = {};
    counted_ = 0;
  }

 private:
  Rise trigger_, reset_;
  double counted_ = 0;  ///< whole: exact up to 2^53
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
      .make = make_node<Counter>,
      .range = range,
  };
  return type;
}

}  // namespace tactus
