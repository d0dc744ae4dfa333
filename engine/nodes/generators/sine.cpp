#include "engine/nodes/generators/sine_kernel.h"
#include "engine/nodes/kernel_node.h"

namespace tactus {

NodeType sine_type() {
  return {
      .name = "sine",
      .summary = "A sine oscillator whose frequency, phase and level are signals.",
      .equation = "out[n] = level * sin(2 pi p[n] + phase); p[0] = 0, p[n+1] = p[n] + frequency[n] / rate",
      .source = "elementary",
      .example = "tone = { type = \"sine\", frequency = \"80 Hz\", level = \"0.5 N\" }",
      .inputs = {{"frequency", "Hz", "frequency in cycles per second; negative: the phase runs backwards"},
                 {"phase", "rad", "phase offset, added to the running phase", 0},
                 {"level", "any", "amplitude", 1}},
      .outputs = {{"out", "=level", "the sine"}},
      .make = make_node<KernelNode<tactus_sine_step, 3>>,
      .range =
          [](int, const NodeSetup& setup) {
            return setup.input("level").range * Interval{-1, 1};
          },
  };
}

}  // namespace tactus
