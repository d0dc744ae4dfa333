#include "engine/nodes/kernel_node.h"
#include "engine/nodes/shapers/antialiased_kernel.h"

namespace tactus {
namespace {

/// Place in the choices, which are in the order of `tactus_shape`.
double shape_of(const NodeSetup& setup) {
  const auto& choices = find_named(setup.type->settings, "shape")->choices;
  return static_cast<double>(std::ranges::find(choices, setup.setting("shape").text) - choices.begin());
}

class ShaperNode final : public KernelNode<tactus_shaper_step, 3, shape_of> {
 public:
  explicit ShaperNode(const NodeSetup& setup)
      : KernelNode<tactus_shaper_step, 3, shape_of>(setup),
        shape_(static_cast<tactus_shape>(shape_of(setup))) {}

  void copy(const Node& other) noexcept override { assign(*this, other); }
  std::optional<std::complex<double>> response(int input, int, std::complex<double> z,
                                               std::span<const double> at) const override {
    const double in = at[0], drive = at[1], level = at[2];
    if (!(level > 0)) return 0;
    const double x = drive * in / level, slope = tactus_shape_slope(shape_, x);
    const auto two_frames = 0.5 * (1.0 + 1.0 / z);
    if (input == 0) return drive * slope * two_frames;
    if (input == 1) return in * slope * two_frames;
    return tactus_shape_value(shape_, x) - x * slope * two_frames;
  }

 private:
  tactus_shape shape_;
};

}  // namespace

NodeType shaper_type() {
  return {
      .name = "shaper",
      .summary = "Distorts a signal by a nonlinear function, antialiased: saturation, clipping, folding.",
      .equation =
          "out = level * mean of f between x[n - 1] and x[n], x = drive * in / level; f: tanh x; soft: x - "
          "4/27 x^3 up "
          "to |x| = 1.5, then +-1; hard: max(-1, min(1, x)); fold: sin x. Half a frame late",
      .source = "Parker, Zavalishin & Le Bivic, DAFx 2016",
      .example = "warm = { type = \"shaper\", in = \"string\", drive = 3 }",
      .inputs = {{"in", "any", "signal"},
                 {"drive", "", "gain before the function; the gain for small signals", 1, 0},
                 {"level", "=in", "level at which it saturates", 1, 0}},
      .outputs = {{"out", "=in", "the distorted signal"}},
      .silencers = {{"in"}},
      .settings = {choice("shape", "the function", {"tanh", "soft", "hard", "fold"}, "tanh")},
      .make = make_node<ShaperNode>,
      .range =
          [](int, const NodeSetup& setup) {
            return max(setup.input("level").range, Interval::exactly(0)) * Interval{-1, 1};
          },
  };
}

}  // namespace tactus
