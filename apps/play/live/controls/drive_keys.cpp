#include "apps/play/live/controls/drive_keys.h"

#include <utility>

namespace tactus::app {

Key DriveKeys::act(Key key, Clock::time_point now) {
  notice_disarm(now);
  const bool on = switches_.armed() || switches_.arm_ordered();
  if (on && (key == 'a' || key == kDisarmKey)) return disarm(now);
  if (key == 'a') return press_a(now);
  if (asked_ && (key == '\r' || key == '\n')) return press_enter(now);
  return press_other(key, now);
}

Key DriveKeys::disarm(Clock::time_point now) {
  switches_.disarm();
  notice_disarm(now);
  pressed_at_ = now;
  return kDisarmedKey;
}

/// Of the presses while the drives are disarmed.
Key DriveKeys::press_a(Clock::time_point now) {
  const bool repeats = now - std::exchange(pressed_at_, now) < kLeast;
  const bool alone = now - disturbed_at_ >= kAlone;
  if (!alone) disturb(now);
  asked_ = alone;
  if (repeats) return kNoKey;
  return alone ? kPressEnterKey : kNotArmedKey;
}

Key DriveKeys::press_enter(Clock::time_point now) {
  disturb(now);
  const auto apart = now - pressed_at_;
  if (apart < kLeast || apart > kMost) return kNotArmedKey;
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
