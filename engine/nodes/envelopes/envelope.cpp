#include "engine/dsp/envelopes/envelope_follower.h"
#include "engine/dsp/envelopes/time_constant.h"
#include "engine/nodes/envelopes/envelopes.h"
#include "engine/nodes/make.h"

namespace tactus {
namespace {

class Envelope final : public Node {
 public:
  explicit Envelope(const NodeSetup& setup) : attack_(setup.sample_rate), release_(setup.sample_rate) {}

  void process(const NodeBlock& block) noexcept override {
    const Signal in = block.in[0], attack = block.in[1], release = block.in[2];
    if (attack.constant() && release.constant() && !in.constant())
      return follower_.run(in.data, block.out[0], block.frames, attack_.keep(attack[0]),
                           release_.keep(release[0]));
    for (int i = 0; i < block.frames; ++i)
      block.out[0][i] = follower_.step(in[i], attack_.keep(attack[i]), release_.keep(release[i]));
  }
  void reset() noexcept override { follower_ = {}; }

 private:
  TimeConstant attack_, release_;
  EnvelopeFollower follower_;
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
