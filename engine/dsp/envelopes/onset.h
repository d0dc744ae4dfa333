#pragma once

// Thread: [realtime]; constructors [control].

#include <algorithm>
#include <array>

#include "engine/core/units.h"

// Without AVX, GCC points out that code with AVX would pass a Four differently. No Four crosses a border
// between files that are compiled with different flags.
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic ignored "-Wpsabi"
#endif

namespace tactus {

/// Four doubles in one register (a vector type of GCC and Clang; without AVX it becomes two). The four bands
/// of the onset detector; Lanes would leave half of its register empty. Operators work lane by lane, `v[i]`
/// is a lane, a comparison gives a mask for `?:`.
using Four = double __attribute__((vector_size(32)));

inline Four max(const Four& a, const Four& b) { return a > b ? a : b; }
inline Four min(const Four& a, const Four& b) { return a < b ? a : b; }
inline Four abs(const Four& a) { return max(a, -a); }
/// Whether a > b in any lane.
inline bool any_above(const Four& a, const Four& b) {
  const auto above = a > b;
  return (above[0] | above[1] | above[2] | above[3]) != 0;
}

/// Detects hits in a microphone signal: soft ones after loud ones, and ringing ones only once.
///
///     y_b   = in, twice through a one-pole high-pass at f_b       f = 30 Hz, 400 Hz, 2 kHz, 7 kHz
///     e_b   = max(|y_b|, e_b exp(-T / tau_b))                     fast envelope, tau = 20, 1, 1, 1 ms
///     bar_b = max(q_b threshold, margin mask_b, margin ring_b, noise_margin floor_b)
///     hit when e_0 > threshold and e_b > bar_b in any band, `hold` or more after the last hit
///
/// Four bands, because a drum rings where it is tuned and a new stroke also excites other frequencies; a
/// weighting towards high frequencies is the usual way to detect it (Bello et al., IEEE Trans. Speech Audio
/// Process. 13, 2005, section III). In each band:
///
/// - mask: the highest envelope of the last hit until its hold was over. Stays for 10 ms more, then falls by
///   20 dB every `mask_time` (by 3 dB in band 0, where drums ring near their peak for long).
/// - ring: the highest envelope of the last 28 ms but the newest 5 (7 in band 0), the oldest counting 3 dB
///   less: what rings and beats, which a stroke outdoes at once. It counts 3 dB more for strokes that stay
///   4 dB or more below the last.
/// - floor: the mean |y_b|. It falls at once and rises by 20 dB a second, but not in the 0.1 s after a hit,
/// so
///   that a long roll does not become noise.
///
/// The upper bands detect nothing for 20, 45 and 60 ms after a hit, because the wires of a snare strike
/// again. The bars change once a millisecond. All these times but the 5 and 7 ms are for `ringing` = 28 ms,
/// and go with it.
///
/// `high_pass` above 30 Hz is for a microphone that also picks up an actuator: hits are then detected only
/// above it, while their strength is still that of the whole signal.
///
/// Valid: sample_rate >= 16 kHz, high_pass below a quarter of it.
class OnsetDetector {
 public:
  struct Settings {
    Hertz sample_rate = 48_kHz;
    Hertz high_pass = 30_Hz;  ///< above 30 Hz: band 0 detects no hits, and the other bands use nothing below
    Seconds mask_time = 20_ms;
    /// How long what is struck rings and rattles, 8 to 31 ms: the window of `ring`, and in proportion the
    /// time for which the mask stays and the upper bands detect nothing. Two strokes closer than this count
    /// as two only if the second is the louder.
    Seconds ringing = 28_ms;
  };
  /// Amplitude ratios; threshold in full scales.
  struct Sensitivity {
    double threshold = 0.02;  ///< -34 dB
    double margin = 1.41;     ///< of a hit over mask and ringing
    double noise_margin = 7;  ///< of a hit over the mean noise (17 dB; 15 dB over the RMS of Gaussian noise)
    Seconds hold = 15_ms;     ///< shorter than 1 ms counts as 1 ms
  };

  class State;

  explicit OnsetDetector(const Settings& settings);

  /// [realtime] True in the frame of a hit. `in` in full scales.
  bool step(State& state, double in, const Sensitivity& sensitivity) const noexcept;

 private:
  static constexpr int kPast = 32;  ///< groups stored: more than `ring` looks back
  static constexpr int kLongAgo = 1000;
  static constexpr int kLevel = 5;  ///< groups in which `level` still rises: 5 ms

  void end_hold(State& state, const Sensitivity& sensitivity) const noexcept;
  void close_group(State& state, const Sensitivity& sensitivity) const noexcept;
  Four ringing(const State& state) const noexcept;

  double sample_rate_;
  int group_frames_;
  int window_, mask_stays_;  ///< groups
  Four feedback_, fast_fall_, mask_fall_, blocked_;
  double mean_rise_, floor_rise_;
};

/// All that changes. A new one starts from silence; the first frame counts as silence, whatever its DC
/// component.
class OnsetDetector::State {
 public:
  /// Envelope above 30 Hz, full scales: time constant 20 ms.
  double envelope() const noexcept { return fast_[0]; }
  /// Highest envelope of the last hit: so far for its first 5 ms, then held until the next.
  double level() const noexcept { return level_; }

 private:
  friend class OnsetDetector;
  double previous_ = 0, level_ = 0;
  Four first_{}, second_{}, fast_{}, mean_{}, group_{}, last_{}, mask_{}, floor_{}, bar_{};
  std::array<Four, kPast> past_{};
  int frame_ = 0;                ///< within the group
  int slot_ = 0;                 ///< in `past_`
  int hold_ = 0;                 ///< frames left in which nothing counts as a hit
  int groups_since_ = kLongAgo;  ///< since the last hit
  int groups_free_ = kLongAgo;   ///< since its hold was over
  int groups_ = 0;               ///< since the first frame
  bool started_ = false;
};

inline bool OnsetDetector::step(State& state, double in, const Sensitivity& sensitivity) const noexcept {
  if (!state.started_) state.previous_ = in;
  state.started_ = true;
  const Four first = feedback_ * (state.first_ + (in - state.previous_));
  const Four second = feedback_ * (state.second_ + (first - state.first_));
  const Four size = abs(second);
  state.previous_ = in;
  state.first_ = first;
  state.second_ = second;
  state.fast_ = max(size, state.fast_ * fast_fall_);
  state.mean_ += mean_rise_ * (size - state.mean_);
  state.group_ = max(state.group_, state.fast_);
  bool hit = false;
  if (state.hold_ > 0) {
    if (--state.hold_ == 0) end_hold(state, sensitivity);
  } else if (any_above(state.fast_, state.bar_) && state.fast_[0] > sensitivity.threshold) {
    hit = true;
    state.hold_ = static_cast<int>(std::max(0.001, sensitivity.hold.value) * sample_rate_ - 0.5);
    state.groups_since_ = 0;
    state.mask_ = state.last_ = state.fast_;
    state.level_ = 0;
  }
  if (state.groups_since_ < kLevel) state.level_ = std::max(state.level_, state.fast_[0]);
  if (++state.frame_ >= group_frames_) close_group(state, sensitivity);
  return hit;
}

}  // namespace tactus
