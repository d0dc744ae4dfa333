#include <cstring>

#include "engine/dsp/envelopes/onset_kernel.h"
#include "engine/nodes/declare.h"

// Without AVX, GCC points out that code with AVX would pass a Four differently: none crosses a file's border.
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic ignored "-Wpsabi"
#endif

namespace tactus {
namespace {

/// The four bands in one register (a vector type of GCC and Clang); Lanes would leave half of it empty.
using Four = double __attribute__((vector_size(32)));

/// `tactus_onset_follow`, vectorised.
[[gnu::always_inline]] inline int follow(tactus_onset& s, double in) noexcept {
  const auto load = [](const double* x) {
    Four four;
    std::memcpy(&four, x, sizeof four);
    return four;
  };
  const auto store = [](const Four& four, double* x) { std::memcpy(x, &four, sizeof four); };
  const auto max = [](const Four& a, const Four& b) { return a > b ? a : b; };
  const double step = s.started != 0 ? in - s.previous : 0;
  s.started = 1;
  s.previous = in;
  const Four feedback = load(s.feedback), before = load(s.first), mean = load(s.mean);
  const Four first = feedback * (before + step), second = feedback * (load(s.second) + (first - before));
  const Four size = max(second, -second), fast = max(size, load(s.fast) * load(s.fast_fall));
  store(first, s.first);
  store(second, s.second);
  store(fast, s.fast);
  store(mean + s.mean_rise * (size - mean), s.mean);
  store(max(load(s.group), fast), s.group);
  const auto above = fast > load(s.bar);
  return (above[0] | above[1] | above[2] | above[3]) != 0;
}

class OnsetNode final : public Node {
  enum Input { kIn, kThreshold, kHold, kMargin, kNoiseMargin, kMaskTime, kHighPass, kRinging };

 public:
  explicit OnsetNode(const NodeSetup& setup) {
    const auto fixed = [&](Input input) { return *setup.inputs[input].constant; };
    tactus_onset_start(&start_, setup.sample_rate.value, fixed(kHighPass), fixed(kMaskTime), fixed(kRinging));
    state_ = start_;
  }

  void process(const NodeBlock& block) noexcept override {
    const Signal* in = block.in;
    for (int i = 0; i < block.frames; ++i) {
      block.out[0][i] = tactus_onset_decide(&state_, follow(state_, in[kIn][i]), in[kThreshold][i],
                                            in[kHold][i], in[kMargin][i], in[kNoiseMargin][i]);
      block.out[1][i] = state_.level;
      block.out[2][i] = state_.fast[0];
    }
  }
  void reset() noexcept override { state_ = start_; }
  void copy(const Node& other) noexcept override { assign(*this, other); }

 private:
  tactus_onset start_{}, state_{};
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
