#pragma once
// Thread: [realtime] unless stated otherwise

#include <algorithm>
#include <cmath>

#include "engine/guard/drive_limits.h"
#include "engine/guard/guard_group.h"

namespace tactus {

/// Limits DC in time. Springs and walls need DC, so it is not blocked; but after `time` it is reduced to a
/// level that may last indefinitely:
///
///   m      mean of the signal before this gain and below the ceiling, first order with τ = 0.5 s
///   spent  rises with time while |m| > level, falls with time while it is not; [0, time]
///   gain   1 while spent < time; then level / |m|, at most 2 a second up or down
///
/// A train of one-sided pulses counts with its mean.
class DcLimiter {
 public:
  static constexpr double kMean_s = 0.5;
  static constexpr double kGainPerSecond = 2.0;

  /// [control]
  DcLimiter(const DcLimits& limits, Hertz sample_rate)
      : limited_(limits.level < 1.0),
        level_(limits.level),
        time_s_(limits.time.value),
        step_s_(kGuardGroup / sample_rate.value),
        mean_share_(-std::expm1(-step_s_ / kMean_s)) {}

  /// [realtime] The signal before this gain, in part of a group.
  void observe(const double* samples, int frames, int position) noexcept {
    if (!limited_) return;
    sum_.add(position, frames, [samples](int n) { return samples[n]; });
  }
  /// [realtime] A group is over. Not inlined: with it the guard's `end_group` is too long to be inlined.
  [[gnu::noinline]] void end_group() noexcept {
    if (!limited_) return;
    mean_ += (sum_.take() / kGuardGroup - mean_) * mean_share_;
    const double size = std::abs(mean_);
    spent_s_ = std::clamp(spent_s_ + (size > level_ ? step_s_ : -step_s_), 0.0, time_s_);
    const double target = size > level_ && spent_s_ >= time_s_ ? level_ / size : 1.0;
    const double step = kGainPerSecond * step_s_;
    gain_.move_to(std::clamp(target, gain_.now() - step, gain_.now() + step));
  }

  const GroupGain& gain() const noexcept { return gain_; }
  /// [control & stopped] `spent`.
  double spent_s() const noexcept { return spent_s_; }
  /// [realtime] At least so much of `time` is spent.
  void spend(double seconds) noexcept { spent_s_ = std::max(spent_s_, std::min(seconds, time_s_)); }

 private:
  bool limited_;
  double level_, time_s_, step_s_, mean_share_;
  GroupSum sum_;
  double mean_ = 0.0, spent_s_ = 0.0;
  GroupGain gain_;
};

}  // namespace tactus
