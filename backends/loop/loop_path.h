#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "backends/loop/loop_card.h"
#include "backends/loop/sinc_line.h"
#include "engine/dsp/envelopes/follower_kernel.h"
#include "engine/dsp/filters/linear_filter.h"
#include "engine/dsp/generators/counter_noise.h"

namespace tactus {

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
