#include "engine/nodes/declare.h"
#include "engine/nodes/logic/clock_kernel.h"

namespace tactus {
namespace {

class ClockNode final : public Node {
  enum Input { kTempo, kDivision, kSwing, kReset };

 public:
  explicit ClockNode(const NodeSetup& setup) : rate_(setup.sample_rate.value) {}

  void process(const NodeBlock& block) noexcept override {
    const Signal* in = block.in;
    for (int n = 0; n < block.frames; ++n) {
      block.out[0][n] =
          tactus_clock_step(&state_, in[kTempo][n] * in[kDivision][n], in[kSwing][n], in[kReset][n], rate_);
      block.out[1][n] = state_.phase;
      block.out[2][n] = state_.count;
    }
  }
  void reset() noexcept override { state_ = {}; }
  void copy(const Node& other) noexcept override { assign(*this, other); }

 private:
  double rate_;
  tactus_clock state_{};
};

}  // namespace

NodeType clock_type() {
  return {
      .name = "clock",
      .summary = "Triggers at a tempo: the steps of a metronome or a sequence, even or with swing.",
      .equation =
          "tempo * division steps a second, the first at the start and at each reset; of each pair of steps, "
          "the first "
          "takes the share `swing` of the time and the second the rest",
      .source = "elementary",
      .example = "beat = { type = \"clock\", tempo = \"120 bpm\", division = 4 }",
      .inputs = {{"tempo", "Hz", "beats per second, as in \"120 bpm\"; 0 stops it", {}, 0},
                 {"division", "", "steps per beat", 1, 0, 1000},
                 {"swing", "", "share of a pair of steps that the first one takes; 2/3: triplets", 0.5, 0.1,
                  0.9},
                 {"reset", "", "trigger that starts the first step of a pair", 0}},
      .outputs = {{.name = "out",
                   .unit = "",
                   .doc = "trigger at each step",
                   .kind = OutputKind::Trigger,
                   .range = {0, 1}},
                  bounded(0, 1, {"phase", "", "position within the step"}),
                  bounded(0, kUnlimited, {"count", "", "steps since the start or the last reset, from 0"})},
      .make = make_node<ClockNode>,
  };
}

}  // namespace tactus
