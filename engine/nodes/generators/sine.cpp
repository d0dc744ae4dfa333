#include <cmath>

#include "engine/dsp/generators/phasor.h"
#include "engine/nodes/generators/generators.h"
#include "engine/nodes/make.h"

namespace tactus {
namespace {

constexpr double kTwoPi = 6.283185307179586;

class Sine final : public Node {
 public:
  explicit Sine(const NodeSetup& setup) : sample_rate_(setup.sample_rate.value) {}

  void process(const NodeBlock& block) noexcept override {
    const Signal frequency = block.in[0], phase = block.in[1], level = block.in[2];
    for (int i = 0; i < block.frames; ++i) {
      const double turns = phasor_.step(frequency[i] / sample_rate_);
      block.out[0][i] = level[i] * std::sin(kTwoPi * turns + phase[i]);
    }
  }
  void reset() noexcept override { phasor_ = {}; }

 private:
  double sample_rate_;
  Phasor phasor_;
};

}  // namespace

const NodeType& sine_type() {
  static const NodeType type = {
      .name = "sine",
      .group = "generators",
      .summary = "Sine of any frequency, with phase and level as signals.",
      .equation = "out[n] = level sin(2 pi p[n] + phase); p[0] = 0, p[n+1] = p[n] + frequency[n] / rate",
      .source = "elementary",
      .example = "tone = { type = \"sine\", frequency = \"80 Hz\", level = \"0.5 N\" }",
      .inputs = {{.name = "frequency", .unit = "Hz", .doc = "turns a second; negative turns backwards"},
                 {.name = "phase", .unit = "rad", .doc = "added to the running phase", .fallback = 0},
                 {.name = "level", .unit = "any", .doc = "amplitude", .fallback = 1}},
      .outputs = {{.name = "out", .unit = "=level", .doc = "the sine"}},
      .make = make_node<Sine>,
      .range =
          [](int, const NodeSetup& setup) {
            return setup.input("level").range * Interval{-1, 1};
          },
  };
  return type;
}

}  // namespace tactus
