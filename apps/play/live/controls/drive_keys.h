#pragma once

#include <atomic>
#include <chrono>

#include "apps/cli/keys.h"
#include "engine/guard/guarded.h"

namespace tactus::app {

/// [any] The last orders to the drives, by the stop loop and by the control thread.
class DriveSwitches {
 public:
  DriveSwitches(Guarded& guarded, bool armed) : guarded_(guarded), armed_(armed) {}

  bool armed() const noexcept { return armed_; }
  bool muted() const noexcept { return muted_; }
  bool arm_ordered() const noexcept { return arm_ordered_; }
  /// How often they were disarmed so far, by whomever.
  int disarms() const noexcept { return disarms_; }

  void mute(bool on) noexcept {
    muted_ = on;
    guarded_.mute(on);
  }
  /// Voids an order to arm as well.
  void disarm() noexcept {
    arm_ordered_ = false;
    armed_ = false;
    guarded_.arm(false);
    ++disarms_;
  }
  /// [any, the stop loop] The control thread is to arm them: it may know a reason not to.
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

/// [any, one thread: the stop loop] Keys that act on the drives at once: m mutes or unmutes, a disarms.
/// Arming is deliberate: a twice, from 100 ms to 1 s apart, with no other byte between and none for 150 ms
/// after them; the control thread then arms. A key that is held down repeats and so never arms. After it, and
/// after a disarm by whomever, a must not be pressed for 1 s before it counts again.
class DriveKeys {
 public:
  using Clock = std::chrono::steady_clock;
  static constexpr std::chrono::milliseconds kLeast{100}, kMost{1000};  ///< between both presses
  static constexpr std::chrono::milliseconds kNothingAfter{150};        ///< both presses
  static constexpr std::chrono::milliseconds kPause{1000};

  explicit DriveKeys(DriveSwitches& switches) : switches_(switches) {}

  /// What the control thread is to know: the key, or what was made of it.
  Key act(Key key, Clock::time_point now);
  /// To be called often: what time has made of the keys.
  Key act_later(Clock::time_point now);

 private:
  enum class State { Idle, PressedOnce, PressedTwice, Pause };

  Key press_arm(Clock::time_point now);
  Key count_press(Clock::duration apart, Clock::duration quiet);
  void notice_disarm(Clock::time_point now);

  DriveSwitches& switches_;
  State state_ = State::Idle;
  Clock::time_point pressed_at_, quiet_since_;  ///< a was pressed; it was, or a disarm was noticed
  int disarms_ = 0;
};

}  // namespace tactus::app
