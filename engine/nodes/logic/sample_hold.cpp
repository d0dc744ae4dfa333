#include "engine/nodes/logic/logic.h"
#include "engine/nodes/logic/sample_hold_kernel.h"
#include "engine/nodes/make.h"

namespace tactus {
namespace {

struct SampleHold {
  static constexpr int kInputs = 2;
  explicit SampleHold(const NodeSetup&) {}
  double step(const double* in) { return tactus_sample_hold_step(&state, in[0], in[1]); }

  tactus_sample_hold state{};
};

}  // namespace

const NodeType& sample_hold_type() {
  static const NodeType type = {
      .name = "sample_hold",
      .group = "logic",
      .summary = "Keeps the value that its input had at the last trigger; 0 before the first.",
      .equation = "out[n] = in[m], m <= n the frame of the last trigger",
      .source = "elementary",
      .example = "velocity = { type = \"sample_hold\", in = \"speed\", trigger = \"hit\" }",
      .inputs = {{.name = "in", .unit = "any", .doc = "signal"},
                 {.name = "trigger", .unit = "", .doc = "when to take the value over"}},
      .outputs = {{.name = "out", .unit = "=in", .doc = "held value"}},
      .make = make_node<KernelNode<SampleHold>>,
      .small_signal_gain = 1,
      .range = [](int,
                  const NodeSetup& setup) { return setup.input("in").range.joined(Interval::exactly(0)); },
  };
  return type;
}

}  // namespace tactus
