#include "engine/dsp/envelopes/follower_kernel.h"
#include "engine/nodes/kernel_node.h"

namespace tactus {

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
      .make = make_node<KernelNode<tactus_envelope_step, 3>>,
      .range =
          [](int, const NodeSetup& setup) {
            return Interval{0, abs(setup.input("in").range).high};
          },
  };
}

}  // namespace tactus
