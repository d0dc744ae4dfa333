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

  void mute(bool on) noexcept {
    muted_ = on;
    guarded_.mute(on);
  }
  /// Voids an order to arm as well.
  void disarm() noexcept {
    arm_ordered_ = false;
    armed_ = false;
    guarded_.arm(false);
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
};

/// [any, one thread: the stop loop] Keys that act on the drives at once: m mutes or unmutes, a disarms.
/// Arming is deliberate: a twice, from 100 ms to 1 s apart, with no other byte between; the control thread
/// then arms.
class DriveKeys {
 public:
  using Clock = std::chrono::steady_clock;
  static constexpr std::chrono::milliseconds kLeast{100}, kMost{1000};  ///< between both presses

  explicit DriveKeys(DriveSwitches& switches) : switches_(switches) {}

  /// What the control thread is to know: the key, or what was made of it.
  Key act(Key key, Clock::time_point now);

 private:
  Key press_arm(Clock::time_point now);

  DriveSwitches& switches_;
  bool pressed_once_ = false;
  Clock::time_point pressed_at_;
};

}  // namespace tactus::app
