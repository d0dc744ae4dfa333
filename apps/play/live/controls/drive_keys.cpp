#include "apps/play/live/controls/drive_keys.h"

#include <algorithm>
#include <utility>

namespace tactus::app {

Key DriveKeys::act(Key key, Clock::time_point now) {
  notice_disarm(now);
  const bool on = switches_.armed() || switches_.arm_ordered();
  if (key == 'a' || key == kDisarmKey) {
    if (on) return disarm(now);
    switches_.disarm();
    ++disarms_;  // this one is no reason to void the arming by keys
  }
  if (key == 'a') return press_a(now);
  if (asked_ && (key == '\r' || key == '\n')) return press_enter(now);
  return press_other(key, now);
}

void DriveKeys::begin_turn(Clock::time_point now) {
  turn_before_ = std::exchange(turned_at_, now).value_or(now);
  notice_disarm(now);
}

Key DriveKeys::disarm(Clock::time_point now) {
  switches_.disarm();
  notice_disarm(now);
  pressed_at_ = now;
  return kDisarmedKey;
}

/// Of the presses while the drives are disarmed. Another a counts for as little as any other key.
Key DriveKeys::press_a(Clock::time_point now) {
  const auto before = std::exchange(pressed_at_, now);
  earliest_press_ = earliest(now);
  const bool alone = earliest_press_ - std::max(before, disturbed_at_) >= kAlone;
  const bool held = !asked_ && now - before < kLeast;
  if (!alone) disturb(now);
  asked_ = alone;
  if (alone) return kPressEnterKey;
  return held ? kNoKey : kNotArmedKey;
}

Key DriveKeys::press_enter(Clock::time_point now) {
  disturb(now);
  if (earliest(now) - pressed_at_ < kLeast || now - earliest_press_ > kMost) return kNotArmedKey;
  switches_.order_arm();
  return kArmKey;
}

Key DriveKeys::press_other(Key key, Clock::time_point now) {
  disturb(now);
  if (key == kDisarmKey) return kNoKey;
  if (key != 'm') return key;
  switches_.mute(!switches_.muted());
  return switches_.muted() ? kMutedKey : kUnmutedKey;
}

/// Whoever presses a at that moment may want to disarm.
void DriveKeys::notice_disarm(Clock::time_point now) {
  const int disarms = switches_.disarms();
  if (std::exchange(disarms_, disarms) != disarms) disturb(now);
}

void DriveKeys::disturb(Clock::time_point now) {
  asked_ = false;
  disturbed_at_ = now;
}

}  // namespace tactus::app
