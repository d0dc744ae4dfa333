#pragma once
// Thread: [realtime] unless stated otherwise

#include <algorithm>
#include <array>
#include <cmath>

#include "engine/core/units.h"
#include "engine/guard/guard_group.h"

namespace tactus {

/// For loops that smooth what `FeedbackProbe` does, or hide it behind a limiter of their own: the drive is
/// silenced until the wanted signal has fallen by 4.4 dB, and let through again, four times. In between it
/// plays for longer than it took to fall, and must not fall then.
///
///   level    the peak of the wanted signal over the last 53 ms, every 11 ms
///   outside  it does not fall within 0.43 s of silence, or it falls while the drive plays, or the drive is
///            not limited again within 10 s
///   loop     it falls four times, in times that agree within a factor of 2; or in two trials it fell four
///            times
class FeedbackTrial {
 public:
  enum class Verdict { None, Feedback, Outside };

  /// [control]
  explicit FeedbackTrial(Hertz sample_rate)
      : groups_(std::max(1, static_cast<int>(std::lround(kStep_s * sample_rate.value / kGuardGroup)))) {}

  bool active() const noexcept { return state_ != State::Idle; }
  bool is_muted() const noexcept { return state_ == State::Muted; }
  void begin() noexcept;
  void forget() noexcept { *this = FeedbackTrial{groups_}; }
  /// A frame while `active`: what was wanted.
  void observe(double wanted) noexcept { peak_ = std::max(peak_, std::abs(wanted)); }
  /// A group is over; `limited`: the drive is being limited.
  Verdict end_group(bool limited) noexcept;

 private:
  enum class State { Idle, First, Muted, Playing };
  static constexpr double kStep_s = 0.0107;
  static constexpr int kCycles = 6;

  explicit FeedbackTrial(int groups) : groups_(groups) {}
  Verdict step(double level, bool limited) noexcept;
  Verdict muted(double level) noexcept;
  Verdict playing(double level, bool limited) noexcept;
  Verdict judge() noexcept;
  void go(State state) noexcept { state_ = state, steps_ = 0; }

  int groups_;  ///< of a step
  State state_ = State::Idle;
  int group_ = 0, steps_ = 0, wait_ = 0, cycles_ = 0, disagreements_ = 0;
  bool limited_again_ = false;
  double peak_ = 0.0, reference_ = 0.0, highest_ = 0.0;
  std::array<double, 5> peaks_{};     ///< of the last steps
  std::array<int, kCycles> falls_{};  ///< steps that each fall took
};

}  // namespace tactus
