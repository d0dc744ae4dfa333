#pragma once

#include <atomic>
#include <chrono>
#include <optional>

#include "apps/cli/keys.h"
#include "engine/guard/guarded.h"

namespace tactus::app {

/// [any] The last orders to the drives, by the stop loop, the control thread and the network thread of
/// `remote/`.
class DriveSwitches {
 public:
  DriveSwitches(Guarded& guarded, bool armed) : guarded_(guarded), armed_(armed) {}

  bool armed() const noexcept { return armed_; }
  bool muted() const noexcept { return muted_; }
  bool arm_ordered() const noexcept { return arm_ordered_; }
  /// How often they were disarmed so far, by whomever.
  int disarms() const noexcept { return disarms_; }

  /// Of two threads that mute and unmute at once, the guard obeys the one that `muted` reports.
  void mute(bool on) noexcept {
    muted_ = on;
    for (bool last = !muted_; last != muted_;) guarded_.mute(last = muted_);
  }
  /// Voids an order to arm as well.
  void disarm() noexcept {
    arm_ordered_ = false;
    armed_ = false;
    guarded_.arm(false);
    ++disarms_;
  }
  /// The control thread is to arm them: it may know a reason not to.
  void order_arm() noexcept { arm_ordered_ = true; }
  /// [control] Obeys the order to arm, unless it was voided; one that comes meanwhile wins.
  void arm() noexcept {
    armed_ = true;
    const bool ordered = arm_ordered_.exchange(false);
    if (ordered) guarded_.arm(true);
    if (!ordered || !armed_) disarm();
  }

 private:
  Guarded& guarded_;
  std::atomic<bool> armed_, muted_{false}, arm_ordered_{false};
  std::atomic<int> disarms_{0};
};

/// [any, one thread: the stop loop] Keys that act on the drives at once: m mutes or unmutes, a disarms, and
/// voids what somebody else is about to arm.
/// Arming takes two keys, so that no key that is held down arms: a, then Enter from 100 ms to 3 s after it.
/// No byte may come between them, not even a second a, and neither a byte nor a disarm in the second before
/// the a. So neither text that is typed or pasted arms, nor several presses of a that were meant to disarm.
/// The control thread then arms.
class DriveKeys {
 public:
  using Clock = std::chrono::steady_clock;
  static constexpr std::chrono::milliseconds kLeast{100}, kMost{3000};  ///< from a to Enter
  static constexpr std::chrono::milliseconds kAlone{1000};              ///< without a byte before a

  explicit DriveKeys(DriveSwitches& switches) : switches_(switches) {}

  /// What the control thread is to know: the key, or what was made of it.
  Key act(Key key, Clock::time_point now);
  /// Once in each turn of the loop, before its keys: by its time a disarm is compared with them. A key may
  /// have been pressed at any time since the turn before, which is long ago if the program was stopped. So
  /// the least times are compared with the shortest time that may have passed, the most with the longest.
  void begin_turn(Clock::time_point now);

 private:
  static constexpr Clock::time_point kNever{-std::chrono::hours{1}};

  Key disarm(Clock::time_point now);
  Key press_a(Clock::time_point now);
  Key press_enter(Clock::time_point now);
  Key press_other(Key key, Clock::time_point now);
  void notice_disarm(Clock::time_point now);
  /// The earliest time at which a key that is read now may have been pressed.
  Clock::time_point earliest(Clock::time_point now) const { return now == turned_at_ ? turn_before_ : now; }
  void disturb(Clock::time_point now);

  DriveSwitches& switches_;
  bool asked_ = false;                                             ///< a was pressed: Enter is to follow
  Clock::time_point pressed_at_ = kNever, disturbed_at_ = kNever;  ///< a; what made it count for nothing
  Clock::time_point earliest_press_ = kNever;                      ///< of that a
  std::optional<Clock::time_point> turned_at_;                     ///< this turn
  Clock::time_point turn_before_ = kNever;
  int disarms_ = 0;
};

}  // namespace tactus::app
