#include <algorithm>
#include <cstring>

#include "engine/dsp/envelopes/onset_kernel.h"
#include "engine/dsp/simd/lanes.h"
#include "engine/nodes/declare.h"

#if defined(__AVX__)
#include <immintrin.h>
#endif

// Without AVX, GCC points out that code with AVX would pass a Four differently: none crosses a file's border.
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic ignored "-Wpsabi"
#endif

namespace tactus {
namespace {

/// The four bands in one register (a vector type of GCC and Clang); Lanes would leave half of it empty.
using Four = double __attribute__((vector_size(32)));

inline Four read(const double* x) noexcept {
  Four four;
  std::memcpy(&four, x, sizeof four);
  return four;
}
inline void write(const Four& four, double* x) noexcept { std::memcpy(x, &four, sizeof four); }
/// As `a > b ? a : b`, in one instruction where there is one.
inline Four max(const Four& a, const Four& b) noexcept {
#if defined(__AVX__)
  return reinterpret_cast<Four>(_mm256_max_pd(reinterpret_cast<__m256d>(a), reinterpret_cast<__m256d>(b)));
#else
  return a > b ? a : b;
#endif
}

/// `tactus_onset_follow` for many frames, vectorised: what changes with each frame stays in registers.
class Bands {
 public:
  explicit Bands(tactus_onset& s) noexcept
      : s_(s),
        feedback_(read(s.feedback)),
        fall_(read(s.fast_fall)),
        bar_(read(s.bar)),
        first_(read(s.first)),
        second_(read(s.second)),
        fast_(read(s.fast)),
        mean_(read(s.mean)),
        group_(read(s.group)) {}
  void follow(double step) noexcept {
    const Four before = first_;
    first_ = feedback_ * (before + step);
    second_ = feedback_ * (second_ + (first_ - before));
    const Four size = max(second_, -second_);
    fast_ = max(size, fast_ * fall_);
    mean_ += s_.mean_rise * (size - mean_);
    group_ = max(group_, fast_);
  }
  bool is_above() const noexcept {
    const auto above = fast_ > bar_;
#if defined(__AVX__)
    return _mm256_movemask_pd(reinterpret_cast<__m256d>(above)) != 0;
#else
    return (above[0] | above[1] | above[2] | above[3]) != 0;
#endif
  }
  double fast() const noexcept { return fast_[0]; }
  void store() const noexcept {
    write(first_, s_.first);
    write(second_, s_.second);
    write(fast_, s_.fast);
    write(mean_, s_.mean);
    write(group_, s_.group);
  }

 private:
  tactus_onset& s_;
  const Four feedback_, fall_, bar_;
  Four first_, second_, fast_, mean_, group_;
};

class OnsetNode final : public Node {
  enum Input { kIn, kThreshold, kHold, kMargin, kNoiseMargin, kMaskTime, kHighPass, kRinging };

 public:
  explicit OnsetNode(const NodeSetup& setup) {
    const auto fixed = [&](Input input) { return *setup.inputs[input].constant; };
    tactus_onset_start(&start_, setup.sample_rate.value, fixed(kHighPass), fixed(kMaskTime), fixed(kRinging));
    state_ = start_;
  }

  void process(const NodeBlock& block) noexcept override {
    for (int n = 0; n < block.frames;) n = run(block, n);
  }
  void reset() noexcept override { state_ = start_; }
  void copy(const Node& other) noexcept override { assign(*this, other); }

 private:
  /// As `tactus_onset_step`, to the end of the block, of the group or of the hold, or to a hit: only the last
  /// of these frames can decide. Returns the frame behind it.
  int run(const NodeBlock& block, int from) noexcept {
    const bool held = state_.hold > 0;
    int to = std::min(block.frames, from + state_.group_frames - state_.frame);
    if (held) to = std::min(to, from + state_.hold);
    bool above = false;
    const int last = held ? follow<true>(block, from, to, above) : follow<false>(block, from, to, above);
    if (held) state_.hold -= last - from;
    state_.frame += last - from;
    const Signal* in = block.in;
    block.out[0][last] = tactus_onset_decide(&state_, above, in[kThreshold][last], in[kHold][last],
                                             in[kMargin][last], in[kNoiseMargin][last]);
    block.out[1][last] = state_.level;
    return last + 1;
  }

  /// Returns the last frame: that of a hit, which is `above`, or the one before `to`.
  template <bool Held>
  int follow(const NodeBlock& block, int from, int to, bool& above) noexcept {
    const Signal in = block.in[kIn], threshold = block.in[kThreshold];
    double* const envelope = block.out[2];
    double previous = state_.started != 0 ? state_.previous : in[from];
    Bands bands(state_);
    int n = from;
    while (true) {
      const double sample = in[n];
      bands.follow(sample - previous);
      previous = sample;
      const double fast = envelope[n] = bands.fast();
      if (!Held && fast > threshold[n] && bands.is_above()) {
        above = true;
        break;
      }
      if (n + 1 == to) break;
      ++n;
    }
    bands.store();
    state_.previous = previous;
    state_.started = 1;
    write_level(block, from, n);
    return n;
  }

  /// Of frames without a hit: the level rises with the envelope for a while after one.
  void write_level(const NodeBlock& block, int from, int to) noexcept {
    double* const level = block.out[1];
    double highest = state_.level;
    fill_samples(block.out[0] + from, to - from, 0);
    if (tactus_onset_rises(&state_) == 0)
      fill_samples(level + from, to - from, highest);
    else
      for (int n = from; n < to; ++n) level[n] = highest = std::max(highest, block.out[2][n]);
    state_.level = highest;
  }

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
