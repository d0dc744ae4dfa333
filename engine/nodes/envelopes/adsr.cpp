#include "engine/dsp/envelopes/adsr.h"

#include <algorithm>

#include "engine/dsp/envelopes/time_constant.h"
#include "engine/nodes/envelopes/envelopes.h"
#include "engine/nodes/make.h"

namespace tactus {
namespace {

class AdsrNode final : public Node {
 public:
  explicit AdsrNode(const NodeSetup& setup)
      : sample_rate_(setup.sample_rate.value), decay_(setup.sample_rate), release_(setup.sample_rate) {}

  void process(const NodeBlock& block) noexcept override {
    const Signal gate = block.in[0], attack = block.in[1], decay = block.in[2], sustain = block.in[3],
                 release = block.in[4];
    for (int i = 0; i < block.frames; ++i) {
      const double attack_frames = attack[i] * sample_rate_;
      const Adsr::Rates rates = {.rise = attack_frames > 1 ? 1 / attack_frames : 1,
                                 .decay_keep = decay_.keep(decay[i]),
                                 .sustain = std::clamp(sustain[i], 0.0, 1.0),
                                 .release_keep = release_.keep(release[i])};
      block.out[0][i] = adsr_.step(gate[i], rates);
    }
  }
  void reset() noexcept override { adsr_ = {}; }

 private:
  double sample_rate_;
  TimeConstant decay_, release_;
  Adsr adsr_;
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
      .make = make_node<AdsrNode>,
  };
  return type;
}

}  // namespace tactus
