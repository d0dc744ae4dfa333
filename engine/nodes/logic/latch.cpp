#include "engine/nodes/logic/latch_kernel.h"
#include "engine/nodes/logic/logic.h"
#include "engine/nodes/make.h"

namespace tactus {
namespace {

struct Latch {
  static constexpr int kInputs = 2;
  explicit Latch(const NodeSetup&) {}
  double step(const double* in) { return tactus_latch_step(&state, in[0], in[1]); }

  tactus_latch state{};
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
      .make = make_node<KernelNode<Latch>>,
  };
  return type;
}

}  // namespace tactus
