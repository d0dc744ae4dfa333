#include "engine/nodes/declare.h"
#include "engine/nodes/generators/random_walk_kernel.h"

namespace tactus {
namespace {

class RandomWalkNode final : public Node {
 public:
  explicit RandomWalkNode(const NodeSetup& setup)
      : key_(tactus_noise_key(static_cast<tactus_noise_bits>(setup.setting("seed").number),
                              static_cast<tactus_noise_bits>(setup.lane))),
        rate_(setup.sample_rate.value) {}

  void process(const NodeBlock& block) noexcept override {
    const Signal time = block.in[0], level = block.in[1];
    for (int n = 0; n < block.frames; ++n)
      block.out[0][n] = level[n] * tactus_random_walk_step(
                                       &state_, key_, static_cast<tactus_noise_bits>(block.first_frame + n),
                                       time[n], rate_);
  }
  void reset() noexcept override { state_ = {}; }
  void copy(const Node& other) noexcept override { assign(*this, other); }

 private:
  tactus_noise_bits key_;
  double rate_;
  tactus_random_walk state_{};
};

}  // namespace

NodeType random_walk_type() {
  return {
      .name = "random_walk",
      .summary = "Wanders at random between -level and level, the same in every run.",
      .equation =
          "out[n] = level * p[n]; p[0] = 0, p[n+1] = p[n] + g(seed, lane, n) / sqrt(rate * time), reflected "
          "at -1 and "
          "1; g: normal distribution.\nUntil it meets an end, the mean square of its distance from the start "
          "is "
          "level^2 * t / time; in the long run all values are equally likely",
      .source = "Feller, An Introduction to Probability Theory and Its Applications, 1968",
      .example = "drift = { type = \"random_walk\", time = \"2 s\", level = \"3 Hz\" }",
      .inputs = {{"time",
                  "s",
                  "typical time from the middle to an end; shorter: it wanders faster",
                  {},
                  0.001,
                  86400},
                 {"level", "any", "largest distance from 0", 1}},
      .outputs = {{"out", "=level", "the walk"}},
      .silencers = {{"level"}},
      .settings = {within(0, 9007199254740992,
                          {"seed", Setting::Kind::Integer, "seed of the random numbers", {}, "1"})},
      .make = make_node<RandomWalkNode>,
      .random = true,
      .range =
          [](int, const NodeSetup& setup) {
            return setup.input("level").range * Interval{-1, 1};
          },
  };
}

}  // namespace tactus
