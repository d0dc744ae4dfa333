#include "engine/dsp/envelopes/envelope_kernel.h"
#include "engine/nodes/envelopes/pulse_kernel.h"
#include "engine/nodes/kernel_node.h"

namespace tactus {
namespace {

class EnvelopeNode final : public KernelNode<tactus_envelope_step, 3> {
  enum Input { kIn, kAttack, kRelease };

 public:
  using KernelNode::KernelNode;

  void process(const NodeBlock& block) noexcept override {
    if (block.frames > 1 && all_constant(block, kAttack, 2) && !block.in[kIn].constant())
      process_with_constant_times(block);
    else
      KernelNode::process(block);
  }

 private:
  void process_with_constant_times(const NodeBlock& block) noexcept {
    const auto keep = [&](tactus_time_constant& time, Input input) {
      return tactus_time_constant_keep(&time, *block.in[input].data, further_);
    };
    const double attack = keep(state_.attack, kAttack), release = keep(state_.release, kRelease);
    const Signal in = block.in[kIn];
    auto follower = state_.follower;  // in registers: the output could overlap a member
    for (int n = 0, frames = block.frames; n < frames; ++n)
      block.out[0][n] = tactus_follower_step(&follower, in[n], attack, release);
    state_.follower = follower;
  }
};

}  // namespace

NodeType envelope_type() {
  return {
      .name = "envelope",
      .summary = "Follows the peaks of a signal.",
      .equation =
          "r = |in|; e += (1 - exp(-1 / (rate t))) (r - e), t = attack while r > e, release otherwise; out = "
          "e",
      .source = "Zölzer (ed.), DAFX: Digital Audio Effects, 2nd ed. 2011, section 4.2",
      .example =
          "loudness = { type = \"envelope\", in = \"microphone\", attack = \"0.5 ms\", release = \"20 ms\" }",
      .inputs = {{"in", "any", "signal"},
                 {"attack", "s", "time constant while the signal is above the envelope; 0: immediate", 0.0005,
                  0},
                 {"release", "s", "time constant while the signal is below the envelope; 0: immediate", 0.020,
                  0}},
      .outputs = {bounded(0, kUnlimited, {"out", "=in", "envelope, never negative"})},
      .silencers = {{"in"}},
      .make = make_node<EnvelopeNode>,
      .range =
          [](int, const NodeSetup& setup) {
            return Interval{0, abs(setup.input("in").range).high};
          },
  };
}

NodeType adsr_type() {
  return {
      .name = "adsr",
      .summary =
          "Envelope of a gate: linear attack, exponential decay to the sustained level, exponential release.",
      .equation =
          "e0 = e before the gate rises. Attack: e = min(1, e0 + t / attack), t = 1 / rate in the gate's "
          "first frame; then e = sustain + (1 - sustain) exp(-t / decay); gate low: e exp(-t / release)",
      .source = "Moore, Elements of Computer Music, 1990",
      .example = "shape = { type = \"adsr\", gate = \"touch\", attack = \"5 ms\", release = \"80 ms\" }",
      .inputs = {{"gate", "", "gate; high: at least 0.5"},
                 {"attack", "s", "attack time from 0 to 1; 0: immediate", 0.005, 0},
                 {"decay", "s", "time constant of the decay to `sustain`", 0.050, 0},
                 {"sustain", "", "level while the gate stays high", 0.7, 0, 1},
                 {"release", "s", "time constant of the release to 0", 0.100, 0}},
      .outputs = {bounded(0, 1, {"out", "", "the envelope"})},
      .silencers = {{"gate"}},
      .make = make_node<KernelNode<tactus_adsr_step, 5>>,
  };
}

}  // namespace tactus
