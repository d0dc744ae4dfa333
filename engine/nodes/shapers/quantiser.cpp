#include "engine/dsp/curves/quantise_kernel.h"
#include "engine/nodes/elementwise.h"
#include "engine/nodes/shapers/shapers.h"

namespace tactus {
namespace {

/// A staircase has no useful linearisation, so this is not an `ElementwiseNode`.
class Quantiser final : public Node {
 public:
  explicit Quantiser(bool nearest) : nearest_(nearest) {}

  void process(const NodeBlock& block) noexcept override {
    for (int i = 0; i < block.frames; ++i) {
      const double in = block.in[0][i], step = block.in[1][i];
      block.out[0][i] = nearest_ ? tactus_quantise_nearest(in, step) : tactus_quantise_floor(in, step);
    }
  }
  void reset() noexcept override {}

 private:
  bool nearest_;
};

}  // namespace

const NodeType& quantiser_type() {
  static const NodeType type = {
      .name = "quantiser",
      .group = "shapers",
      .summary = "Rounds a signal to multiples of a step, as an encoder or a converter does.",
      .equation =
          "nearest: out = step * round(in / step), halves to the even multiple; floor: out = step * floor(in "
          "/ step)",
      .source = "Widrow & Kollar, Quantization Noise, 2008",
      .example =
          "encoder = { type = \"quantiser\", in = \"angle\", step = \"0.09 deg\", rounding = \"floor\" }",
      .inputs = {{.name = "in", .unit = "any", .doc = "signal"},
                 {.name = "step",
                  .unit = "=in",
                  .doc = "distance of the steps; where a signal makes it 0, nothing is rounded",
                  .low = 0}},
      .outputs = {{.name = "out", .unit = "=in", .doc = "rounded signal"}},
      .settings = {{.name = "rounding",
                    .kind = Setting::Kind::Choice,
                    .doc = "which multiple of the step",
                    .choices = {"nearest", "floor"},
                    .fallback = "nearest"}},
      .make = [](const NodeSetup& setup) -> Result<std::unique_ptr<Node>> {
        if (setup.input("step").constant == 0.0)
          return fail(Errc::OutOfRange, {}, "its 'step' is 0, so that it rounds nothing",
                      "give the distance of two steps, or leave the node out");
        return std::make_unique<Quantiser>(setup.setting("rounding").text == "nearest");
      },
      .stateless = true,
      .small_signal_gain = 1,
      .range =
          [](int, const NodeSetup& setup) {
            const Interval step = max(setup.input("step").range, Interval::exactly(0));
            return setup.input("in").range + Interval{-step.high, step.high};
          },
  };
  return type;
}

}  // namespace tactus
