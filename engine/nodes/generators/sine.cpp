#include "engine/nodes/generators/generators.h"
#include "engine/nodes/generators/sine_kernel.h"
#include "engine/nodes/make.h"

namespace tactus {
namespace {

struct Sine {
  static constexpr int kInputs = 3;
  explicit Sine(const NodeSetup& setup) : rate(setup.sample_rate.value) {}
  double step(const double* in) { return tactus_sine_step(&state, in[0], in[1], in[2], rate); }

  double rate;
  tactus_phasor state{};
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
      .make = make_node<KernelNode<Sine>>,
      .range =
          [](int, const NodeSetup& setup) {
            return setup.input("level").range * Interval{-1, 1};
          },
  };
  return type;
}

}  // namespace tactus
