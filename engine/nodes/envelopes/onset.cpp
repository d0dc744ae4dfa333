#include "engine/dsp/envelopes/onset.h"

#include <algorithm>

#include "engine/nodes/declare.h"

namespace tactus {
namespace {

class OnsetNode final : public Node {
  enum Input { kIn, kThreshold, kHold, kMargin, kNoiseMargin, kMaskTime, kHighPass, kRinging };

 public:
  explicit OnsetNode(const NodeSetup& setup)
      : detector_({.sample_rate = setup.sample_rate,
                   .high_pass = Hertz{*setup.inputs[kHighPass].constant},
                   .mask_time = Seconds{*setup.inputs[kMaskTime].constant},
                   .ringing = Seconds{*setup.inputs[kRinging].constant}}) {}

  void process(const NodeBlock& block) noexcept override {
    const Signal* in = block.in;
    OnsetDetector::Sensitivity sensitivity;
    for (int i = 0; i < block.frames; ++i) {
      sensitivity.threshold = in[kThreshold][i];
      sensitivity.margin = in[kMargin][i];
      sensitivity.noise_margin = in[kNoiseMargin][i];
      sensitivity.hold = Seconds{std::clamp(in[kHold][i], 0.001, 10.0)};
      const bool hit = detector_.step(state_, in[kIn][i], sensitivity);
      block.out[0][i] = hit ? 1 : 0;
      block.out[1][i] = state_.level();
      block.out[2][i] = state_.envelope();
    }
  }
  void reset() noexcept override { state_ = {}; }

 private:
  OnsetDetector detector_;
  OnsetDetector::State state_;
};

}  // namespace

NodeType onset_type() {
  return {
      .name = "onset",
      .summary =
          "Triggers at each hit in a microphone signal; detects soft hits after loud ones, and a ringing hit "
          "only once.",
      .equation =
          "e = fast envelope of in above 30 Hz, 400 Hz, 2 kHz and 7 kHz; a hit when e > threshold in the "
          "first, and in any e > margin * last hit's mask, e > margin * highest e of the last ringing, and e "
          "> noise_margin * mean noise; then none for hold",
      .source = "Bello et al., IEEE Trans. Speech Audio Process. 13, 2005",
      .example = "hit = { type = \"onset\", in = \"microphone\", threshold = \"-34 dB\", hold = \"15 ms\" }",
      .inputs = {{"in", "full scale", "microphone"},
                 {.name = "threshold",
                  .unit = "",
                  .doc = "peak level of the softest hit",
                  .fallback = 0.01995262314968880,  // -34 dB
                  .low = 0},
                 event_hold(
                     {"hold", "s", "time after a hit in which no other hit is detected", 0.015, 0.001, 10}),
                 {.name = "margin",
                  .unit = "",
                  .doc = "ratio by which a hit must exceed the ringing of the last hit; larger: more missed, "
                         "fewer double hits",
                  .fallback = 1.41253754462275,  // 3 dB
                  .low = 0},
                 {"noise_margin", "", "ratio by which a hit must exceed the mean noise", 7.0, 0},
                 fixed({"mask_time", "s",
                        "time in which the mask of a hit falls by 20 dB, from 10 ms after its hold", 0.020,
                        0.001, 10}),
                 fixed({"high_pass", "Hz",
                        "lowest level of a hit; raise it if the microphone picks up an actuator", 30, 1,
                        4000}),
                 fixed({"ringing", "s",
                        "ringing time of the struck object; shorter: detects denser strokes, longer: fewer "
                        "double hits",
                        0.028, 0.008, 0.031})},
      .outputs = {{.name = "hit",
                   .unit = "",
                   .doc = "1 in the frame of a hit",
                   .kind = OutputKind::Trigger,
                   .range = {0, 1}},
                  {.name = "level",
                   .unit = "=in",
                   .doc =
                       "peak envelope of the last hit: follows its first 5 ms, then holds until the next hit",
                   .event_level = true},
                  {"envelope", "=in", "fast envelope above 30 Hz"}},
      .make = make_node<OnsetNode>,
  };
}

}  // namespace tactus
