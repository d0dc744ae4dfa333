#include "engine/dsp/envelopes/stroke.h"

#include <algorithm>

#include "engine/nodes/declare.h"

namespace tactus {
namespace {

const std::vector<std::string> kLookaheads = {"0.5 ms", "1 ms", "2 ms", "3 ms"};

const tactus_stroke_net& net_for(const std::string& lookahead) {
  std::ptrdiff_t index = 0;
  while (kLookaheads[static_cast<std::size_t>(index)] != lookahead) ++index;
  return tactus_stroke_nets[index];
}

class StrokeNode final : public Node {
  enum Input { kIn, kReference, kThreshold, kHold };

 public:
  explicit StrokeNode(const NodeSetup& setup) : referenced_(setup.inputs[kReference].constant != 0.0) {
    tactus_stroke_start(&start_, setup.sample_rate.value, &net_for(setup.setting("lookahead").text));
    state_ = start_;
  }

  void process(const NodeBlock& block) noexcept override {
    const Signal* in = block.in;
    for (int from = 0; from < block.frames;) {
      const int count = tactus_stroke_samples_left(&state_, std::min(kMost, block.frames - from));
      const int last = from + count - 1;
      double heard[kMost], thrown[kMost];
      for (int i = 0; i < count; ++i) heard[i] = tactus_stroke_finite(in[kIn][from + i]);
      for (int i = 0; referenced_ && i < count; ++i)
        thrown[i] = tactus_stroke_finite(in[kReference][from + i]);
      for (int i = from; i < last; ++i) write(block, i, 0);
      const int stroke = follow_stroke(state_, heard, referenced_ ? thrown : nullptr, count,
                                       in[kThreshold][last], in[kHold][last]);
      write(block, last, stroke);
      from += count;
    }
  }
  void reset() noexcept override { state_ = start_; }
  void copy(const Node& other) noexcept override { assign(*this, other); }

 private:
  static constexpr int kMost = 64;

  void write(const NodeBlock& block, int frame, int stroke) const noexcept {
    block.out[0][frame] = stroke;
    block.out[1][frame] = state_.level;
    block.out[2][frame] = state_.evidence;
  }

  bool referenced_;
  tactus_stroke start_{}, state_{};
};

}  // namespace

NodeType stroke_type() {
  return {
      .name = "stroke",
      .summary =
          "Triggers at each stroke on a drum, also in a dense roll with accents; a small neural network "
          "judges the levels of eight bands every 0.5 ms.",
      .equation =
          "z = net(rise, recent levels, floor of 8 bands); a stroke at the end of a frame of 0.5 ms when z > "
          "bar, hold after the last, its peak > threshold; the reference masks what it predicts + 10 dB",
      .source = "Boeck, Arzt, Krebs, Schedl, Proc. DAFx 2012 (a network for causal onset detection)",
      .example = "hit = { type = \"stroke\", in = \"microphone\", lookahead = \"1 ms\" }",
      .inputs = {{"in", "full scale", "microphone"},
                 {.name = "reference",
                  .unit = "full scale",
                  .doc =
                      "signal of the actuator that the microphone picks up, at most 10 ms before it arrives: "
                      "its sound is no stroke",
                  .fallback = 0},
                 {.name = "threshold",
                  .unit = "",
                  .doc = "peak level of the softest stroke",
                  .fallback = 0.001,  // -60 dB
                  .low = 0},
                 event_hold(
                     {"hold", "s", "time after a stroke in which no other is detected", 0.010, 0.001, 10})},
      .outputs = {{.name = "hit",
                   .unit = "",
                   .doc = "1 in the frame in which a stroke is decided",
                   .kind = OutputKind::Trigger,
                   .range = {0, 1}},
                  {.name = "level",
                   .unit = "=in",
                   .doc = "peak above 30 Hz of the last stroke: follows its first 5 ms, then holds",
                   .event_level = true},
                  bounded(-50, 50, {"evidence", "", "z: log odds of a stroke, each 0.5 ms"})},
      .settings = {choice(
          "lookahead",
          "time after the onset that the network is trained to use; longer: fewer errors, up to "
          "this much later",
          kLookaheads, "1 ms")},
      .make = make_node<StrokeNode>,
  };
}

}  // namespace tactus
