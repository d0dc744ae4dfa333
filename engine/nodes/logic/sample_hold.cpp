#include "engine/dsp/envelopes/rise.h"
#include "engine/nodes/logic/logic.h"
#include "engine/nodes/make.h"

namespace tactus {
namespace {

class SampleHold final : public Node {
 public:
  explicit SampleHold(const NodeSetup&) {}

  void process(const NodeBlock& block) noexcept override {
    const Signal in = block.in[0], trigger = block.in[1];
    for (int i = 0; i < block.frames; ++i) {
      if (rise_.step(trigger[i])) held_ = in[i];
      block.out[0][i] = held_;
    }
  }
  void reset() noexcept override {
    rise_ = {};
    held_ = 0;
  }

 private:
  Rise rise_;
  double held_ = 0;
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
      .make = make_node<SampleHold>,
      .small_signal_gain = 1,
      .range = [](int,
                  const NodeSetup& setup) { return setup.input("in").range.joined(Interval::exactly(0)); },
  };
  return type;
}

}  // namespace tactus
