#include "engine/dsp/envelopes/rise.h"
#include "engine/nodes/logic/logic.h"
#include "engine/nodes/make.h"

namespace tactus {
namespace {

class Latch final : public Node {
 public:
  explicit Latch(const NodeSetup&) {}

  void process(const NodeBlock& block) noexcept override {
    const Signal set = block.in[0], reset = block.in[1];
    for (int i = 0; i < block.frames; ++i) {
      if (set_.step(set[i])) on_ = true;
      if (reset_.step(reset[i])) on_ = false;
      block.out[0][i] = on_ ? 1 : 0;
    }
  }
  void reset() noexcept override {
    set_ = {};
    reset_ = {};
    on_ = false;
  }

 private:
  Rise set_, reset_;
  bool on_ = false;
};

}  // namespace

const NodeType& latch_type() {
  static const NodeType type = {
      .name = "latch",
      .group = "logic",
      .summary = "Goes to 1 at one trigger and back to 0 at another, which wins if both come in one frame.",
      .equation = "out = 1 from a trigger at `set` until one at `reset`",
      .source = "elementary",
      .example = "playing = { type = \"latch\", set = \"start\", reset = \"stop\" }",
      .inputs = {{.name = "set", .unit = "", .doc = "trigger that switches on"},
                 {.name = "reset", .unit = "", .doc = "trigger that switches off", .fallback = 0}},
      .outputs = {{.name = "out", .unit = "", .doc = "0 or 1", .range = {0, 1}}},
      .make = make_node<Latch>,
  };
  return type;
}

}  // namespace tactus
