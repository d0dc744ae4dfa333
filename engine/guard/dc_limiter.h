#pragma once

#include "engine/guard/drive_limits.h"
#include "engine/guard/guard_group.h"

namespace tactus {

/// Direct current for a limited time. Springs and walls need it, so it is not blocked; but what holds for
/// longer than that is brought down to what may last for ever:
///
///   m      mean of what is wanted (before this gain, below the ceiling), first order with τ = 0.5 s
///   spent  rises with time while |m| > level, falls with time while it is not; [0, time]
///   gain   1 while spent < time; then level / |m|, at most 2 a second up or down
///
/// A train of one-sided pulses counts as what it is on average.
class Direct {
 public:
  static constexpr double kMean_s = 0.5;
  static constexpr double kGainPerSecond = 2.0;

  /// [control]
  Direct(const DirectLimits& limits, Hertz sample_rate);

  /// [realtime] What is wanted in a piece of a group.
  void hear(const double* samples, int frames, int position) noexcept {
    if (!limited_) return;
    sum_.add(position, frames, [samples](int n) { return samples[n]; });
  }
  /// [realtime] A group is over.
  void end_group() noexcept;

  const GroupGain& gain() const noexcept { return gain_; }

 private:
  bool limited_;
  double level_, time_s_, step_s_, mean_share_;
  GroupSum sum_;
  double mean_ = 0.0, spent_s_ = 0.0;
  GroupGain gain_;
};

}  // namespace tactus
