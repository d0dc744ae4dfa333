#include "engine/dsp/curves/curve_kernel.h"
#include "engine/nodes/kernel_node.h"

namespace tactus {

NodeType quantiser_type() {
  return {
      .name = "quantiser",
      .summary = "Rounds a signal to multiples of a step, as an encoder or a converter does.",
      .equation =
          "nearest: out = step * round(in / step), halves to the even multiple; floor: out = step * floor(in "
          "/ step)",
      .source = "Widrow & Kollar, Quantization Noise, 2008",
      .example =
          "encoder = { type = \"quantiser\", in = \"angle\", step = \"0.09 deg\", rounding = \"floor\" }",
      .inputs = {{"in", "any", "signal"},
                 {"step", "=in", "step size; if a signal sets it to 0, nothing is rounded", {}, 0}},
      .outputs = {{"out", "=in", "rounded signal"}},
      .settings = {choice("rounding", "rounding: to the nearest or to the lower multiple of the step",
                          {"nearest", "floor"}, "nearest")},
      .make = [](const NodeSetup& setup) -> Result<std::unique_ptr<Node>> {
        if (setup.input("step").constant == 0.0)
          return fail(Errc::OutOfRange, {}, "its 'step' is 0, so nothing is rounded",
                      "give a step above 0, or remove the node");
        struct None {};
        const bool nearest = setup.setting("rounding").text == "nearest";
        // Not an `ElementwiseNode`: a staircase has no useful linearisation.
        return make_step_node<2, None>([nearest](None, double in, double step) {
          return nearest ? tactus_quantise_nearest(in, step) : tactus_quantise_floor(in, step);
        });
      },
      .stateless = true,
      .small_signal_gain = 1,
      .range =
          [](int, const NodeSetup& setup) {
            const Interval step = max(setup.input("step").range, Interval::exactly(0));
            return setup.input("in").range + Interval{-step.high, step.high};
          },
  };
}

}  // namespace tactus
