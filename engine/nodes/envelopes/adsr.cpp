
#include "engine/nodes/envelopes/adsr_kernel.h"
#include "engine/nodes/envelopes/envelopes.h"
#include "engine/nodes/make.h"

namespace tactus {
namespace {

struct Adsr {
  static constexpr int kInputs = 5;
  explicit Adsr(const NodeSetup& setup) : rate(setup.sample_rate.value) {}
  double step(const double* in) { return tactus_adsr_step(&state, in[0], in[1], in[2], in[3], in[4], rate); }

  double rate;
  tactus_adsr state{};
};

}  // namespace

const NodeType& adsr_type() {
  static const NodeType type = {
      .name = "adsr",
      .group = "envelopes",
      .summary =
          "Envelope of a gate: linear attack, exponential decay to the sustained level, exponential release.",
      .equation =
          "e before the gate rises: e0. Attack: e = min(1, e0 + t / attack), t = 1 / rate in the gate's "
          "first frame; then "
          "e = sustain + (1 - sustain) exp(-t / decay); gate low: e exp(-t / release)",
      .source = "Moore, Elements of Computer Music, 1990",
      .example = "shape = { type = \"adsr\", gate = \"touch\", attack = \"5 ms\", release = \"80 ms\" }",
      .inputs =
          {{.name = "gate", .unit = "", .doc = "high from 0.5 on"},
           {.name = "attack",
            .unit = "s",
            .doc = "time of the way from 0 to 1; 0: at once",
            .fallback = 0.005,
            .low = 0},
           {.name = "decay",
            .unit = "s",
            .doc = "time constant towards `sustain`",
            .fallback = 0.050,
            .low = 0},
           {.name = "sustain",
            .unit = "",
            .doc = "level while the gate stays high",
            .fallback = 0.7,
            .low = 0,
            .high = 1},
           {.name = "release", .unit = "s", .doc = "time constant towards 0", .fallback = 0.100, .low = 0}},
      .outputs = {{.name = "out", .unit = "", .doc = "the envelope", .range = {0, 1}}},
      .make = make_node<KernelNode<Adsr>>,
  };
  return type;
}

}  // namespace tactus
