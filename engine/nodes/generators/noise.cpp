#include "engine/dsp/generators/counter_noise.h"
#include "engine/nodes/declare.h"

namespace tactus {
namespace {

class NoiseNode final : public Node {
 public:
  explicit NoiseNode(const NodeSetup& setup)
      : noise_(static_cast<std::uint64_t>(setup.setting("seed").number),
               static_cast<std::uint64_t>(setup.lane)),
        uniform_(setup.setting("distribution").text == "uniform") {}

  void process(const NodeBlock& block) noexcept override {
    const Signal level = block.in[0];
    for (int i = 0; i < block.frames; ++i) {
      const std::int64_t frame = block.first_frame + i;
      block.out[0][i] = level[i] * (uniform_ ? noise_.uniform(frame) : noise_.gaussian(frame));
    }
  }
  void reset() noexcept override {}

 private:
  CounterNoise noise_;
  bool uniform_;
};

Interval noise_range(int, const NodeSetup& setup) {
  // sqrt(-2 ln 2^-53) = 8.57: the largest value that a 53-bit number leads to.
  const double peak = setup.setting("distribution").text == "uniform" ? 1 : 8.6;
  return setup.input("level").range * Interval{-peak, peak};
}

}  // namespace

NodeType noise_type() {
  return {
      .name = "noise",
      .summary = "White noise, the same in every run: each value is a function of seed, lane and frame.",
      .equation = "out[n] = level * u(seed, lane, n); uniform: in [-1, 1); gaussian: standard deviation 1",
      .source = "Steele, Lea & Flood, OOPSLA 2014 (SplitMix64); Box & Muller, Ann. Math. Stat. 1958",
      .example = "hiss = { type = \"noise\", seed = 7, level = \"-40 dB\" }",
      .inputs = {{"level", "any", "peak of uniform noise, standard deviation of gaussian noise", 1}},
      .outputs = {{"out", "=level", "the noise"}},
      .silencers = {{"level"}},
      .settings = {within(0, 9007199254740992,
                          {"seed", Setting::Kind::Integer, "seed of the noise", {}, "1"}),
                   choice("distribution", "distribution of the values", {"uniform", "gaussian"}, "uniform")},
      .make = make_node<NoiseNode>,
      .random = true,
      .range = noise_range,
  };
}

}  // namespace tactus
