#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "backends/loop/loop_card.h"
#include "engine/core/index.h"
#include "engine/dsp/envelopes/envelope_kernel.h"
#include "engine/dsp/filters/linear_filter.h"
#include "engine/dsp/generators/counter_noise.h"

namespace tactus {

/// The past of a signal, read between its frames: a sinc under a Gaussian of 9 frames, cut off where that is
/// 1e-6. By the width of the Gaussian's spectrum, what lies below 0.42 of the rate is right to 1e-5, in gain
/// and in radians; whole frames are exact.
class SincLine {
 public:
  static constexpr int kReach = 48;  ///< frames on each side of where it is read

  /// [control] `back`: as far as it is read behind the newest frame that was written.
  explicit SincLine(std::int64_t back);

  /// [realtime] Frames begin at 0 and are all 0 at first.
  void add(std::int64_t frame, double value) noexcept { at(frame) += value; }
  /// [realtime] `frame` and what is behind it are of no use any more.
  void forget(std::int64_t frame) noexcept { at(frame) = 0.0; }
  /// [realtime] At `frame` + `fraction`, 0 <= fraction < 1.
  double read(std::int64_t frame, double fraction) noexcept;
  double operator[](std::int64_t frame) const noexcept { return samples_[index(frame) & mask_]; }

 private:
  double& at(std::int64_t frame) noexcept { return samples_[index(frame) & mask_]; }

  std::vector<double> samples_;
  std::size_t mask_;
  double fraction_ = 0.0;  ///< that `taps_` are for
  std::array<double, 2 * kReach> taps_{};
};

/// Removes from the recording what it can predict from what was played, as voice chat programs do: an
/// adaptive filter by normalised least mean squares,
///   e[n] = y[n] - w·u[n],   w += mu e[n] u[n] / (u[n]·u[n] + eps),   u[n] = what was played around n - D.
/// Source: S. Haykin, "Adaptive Filter Theory", 4th ed., chapter 6.
class EchoCanceller {
 public:
  /// How far ahead of the delay it looks.
  static constexpr int kAhead = SincLine::kReach;

  /// [realtime] `newest`: the frame of `played` with which it begins.
  double step(const SincLine& played, std::int64_t newest, double captured) noexcept {
    double made = 0.0, power = 0.0;
    for (int k = 0; k < kTaps; ++k) {
      const double sample = played[newest - k];
      made += weights_[index(k)] * sample;
      power += sample * sample;
    }
    const double left = captured - made;
    const double push = kStep * left / (power + kLeastPower);
    for (int k = 0; k < kTaps; ++k) weights_[index(k)] += push * played[newest - k];
    return left;
  }

 private:
  static constexpr int kTaps = 128;
  static constexpr double kStep = 0.005;
  static constexpr double kLeastPower = 1e-7;

  std::array<double, kTaps> weights_{};
};

/// Where the frames of an opening go, the same for all its channels.
struct LoopTiming {
  Hertz sample_rate = 48_kHz;
  int block_frames = 64;
  int buffer_frames = 0;         ///< from the processor to the converter
  double hardware_frames = 0.0;  ///< from the output converter to the input converter
};

/// The way from one output to one input.
class LoopPath {
 public:
  /// [control] `lane`: each has noise of its own.
  LoopPath(const LoopCard& card, const LoopTiming& timing, int lane);

  /// [realtime] What comes in at `frame`, `later` frames later than usual. Frames come one after another.
  double record(std::int64_t frame, double later) noexcept;
  /// [realtime] What goes out at `frame`; all of a block at once, after it was recorded.
  void play(std::int64_t frame, double sample) noexcept;

 private:
  double converted(double sample) const noexcept;
  double controlled(double sample) noexcept;

  LoopCard card_;
  LoopTiming timing_;
  SincLine line_;      ///< what the output plays
  SincLine captured_;  ///< for the monitor
  CounterNoise noise_;
  std::optional<LinearFilter<1>> high_pass_;
  std::optional<EchoCanceller> canceller_;
  tactus_follower level_{};
  double attack_keep_, release_keep_;
  double step_;
  int monitor_frames_;
  bool played_ = false;  ///< anything yet
};

}  // namespace tactus
