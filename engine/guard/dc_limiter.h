#pragma once
// Thread: [realtime] unless stated otherwise

#include <algorithm>
#include <cmath>

#include "engine/core/every_block.h"
#include "engine/guard/drive_limits.h"
#include "engine/guard/guard_group.h"

namespace tactus {

/// Limits DC in time. Springs and walls need DC, so it is not blocked; but after `time` it is reduced to a
/// level that may last indefinitely:
///
///   m      mean of the signal before this gain and below the ceiling, first order with τ = 0.5 s
///   o, g   the same means of the output, behind the slew and excursion limits, and of this gain
///   d      max(|m|, |o| / g): those limits make DC of an asymmetric signal whose own mean is 0
///   spent  rises with time while d > level, falls with time while it is not; [0, time]
///   gain   1 while spent < time; then level / d, at most 2 a second up or down
///
/// Without limiting behind it o / g is m. With it, o falls at least as fast as g, and a gain at which
/// |o| = level is the only one that remains: o / g falls with g, so it is reached from both sides.
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

  /// [realtime] The signal before this gain, in part of a group. The output is the same.
  void observe(const double* samples, int frames, int position) noexcept {
    if (!limited_) return;
    sum_.add(position, frames, [samples](int n) { return samples[n]; });
  }
  /// [realtime] The same, with another output.
  void observe(const double* samples, const double* output, int frames, int position) noexcept {
    observe(samples, frames, position);
    if (!limited_) return;
    change_sum_.add(position, frames, [=](int n) { return output[n] - samples[n]; });
  }
  /// [realtime] A group is over. Not inlined: with it the guard's `end_group` is too long to be inlined.
  TACTUS_EVERY_BLOCK [[gnu::noinline]] void end_group() noexcept {
    if (!limited_) return;
    mean_ += (sum_.take() / kGuardGroup - mean_) * mean_share_;
    mean_change_ += (change_sum_.take() / kGuardGroup - mean_change_) * mean_share_;
    mean_gain_ += (gain_.mean() - mean_gain_) * mean_share_;
    const double size = largest_dc();
    spent_s_ = std::clamp(spent_s_ + (size > level_ ? step_s_ : -step_s_), 0.0, time_s_);
    const double target = size > level_ && spent_s_ >= time_s_ ? level_ / size : 1.0;
    const double step = kGainPerSecond * step_s_;
    gain_.move_to(std::clamp(target, gain_.now() - step, gain_.now() + step));
  }

  const GroupGain& gain() const noexcept { return gain_; }
  /// [control & stopped] `spent`.
  double spent_s() const noexcept { return spent_s_; }
  /// [any] `time`.
  double most_s() const noexcept { return time_s_; }
  /// [realtime] At least so much of `time` is spent.
  void spend(double seconds) noexcept { spent_s_ = std::max(spent_s_, std::min(seconds, time_s_)); }

 private:
  /// d. A quotient that is m but for rounding counts as m, so that rounding changes no bit of the output.
  double largest_dc() const noexcept {
    constexpr double kRounding = 1e-9;
    const double before = std::abs(mean_), behind = std::abs(mean_ + mean_change_);
    return behind > before * mean_gain_ + kRounding ? behind / mean_gain_ : before;
  }

  bool limited_;
  double level_, time_s_, step_s_, mean_share_;
  GroupSum sum_, change_sum_;
  double mean_ = 0.0, mean_change_ = 0.0, mean_gain_ = 1.0, spent_s_ = 0.0;
  GroupGain gain_;
};

}  // namespace tactus
