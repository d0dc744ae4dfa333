#include "engine/dsp/envelopes/follower_kernel.h"
#include "engine/dsp/envelopes/time_constant_kernel.h"
#include "engine/nodes/envelopes/envelopes.h"
#include "engine/nodes/make.h"

namespace tactus {
namespace {

class Envelope final : public Node {
 public:
  explicit Envelope(const NodeSetup& setup) : rate_(setup.sample_rate.value) {}

  void process(const NodeBlock& block) noexcept override {
    const Signal in = block.in[0], attack = block.in[1], release = block.in[2];
    if (attack.constant() && release.constant() && !in.constant())
      return tactus_follower_run(&follower_, in.data, block.out[0], block.frames, keep(attack_, attack[0]),
                                 keep(release_, release[0]));
    for (int i = 0; i < block.frames; ++i)
      block.out[0][i] =
          tactus_follower_step(&follower_, in[i], keep(attack_, attack[i]), keep(release_, release[i]));
  }
  void reset() noexcept override { follower_ = {}; }

 private:
  double keep(tactus_time_constant& time, double seconds) const noexcept {
    return tactus_time_constant_keep(&time, seconds, rate_);
  }

  double rate_;
  tactus_time_constant attack_{}, release_{};
  tactus_follower follower_{};
};

}  // namespace

const NodeType& envelope_type() {
  static const NodeType type = {
      .name = "envelope",
      .group = "envelopes",
      .summary = "Follows the peaks of a signal.",
      .equation =
          "r = |in|; e += (1 - exp(-1 / (rate t))) (r - e), t = attack while r > e, release otherwise; out = "
          "e",
      .source = "Zölzer (ed.), DAFX: Digital Audio Effects, 2nd ed. 2011, section 4.2",
      .example =
          "loudness = { type = \"envelope\", in = \"microphone\", attack = \"0.5 ms\", release = \"20 ms\" }",
      .inputs = {{.name = "in", .unit = "any", .doc = "signal"},
                 {.name = "attack",
                  .unit = "s",
                  .doc = "time constant while the signal is above the envelope; 0: at once",
                  .fallback = 0.0005,
                  .low = 0},
                 {.name = "release",
                  .unit = "s",
                  .doc = "time constant while it is below; 0: at once",
                  .fallback = 0.020,
                  .low = 0}},
      .outputs =
          {{.name = "out", .unit = "=in", .doc = "envelope, never negative", .range = {0, kUnlimited}}},
      .make = make_node<Envelope>,
      .range =
          [](int, const NodeSetup& setup) {
            return Interval{0, abs(setup.input("in").range).high};
          },
  };
  return type;
}

}  // namespace tactus
