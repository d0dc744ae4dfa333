#include "apps/play/live/controls/drive_keys.h"

#include <utility>

namespace tactus::app {

Key DriveKeys::act(Key key, Clock::time_point now) {
  if (key == 'a') return press_arm(now);
  pressed_once_ = false;
  if (key != 'm') return key;
  switches_.mute(!switches_.muted());
  return switches_.muted() ? kMutedKey : kUnmutedKey;
}

Key DriveKeys::press_arm(Clock::time_point now) {
  const bool twice = std::exchange(pressed_once_, false);
  const auto apart = now - std::exchange(pressed_at_, now);
  if (switches_.armed() || switches_.arm_ordered()) {
    switches_.disarm();
    return kDisarmedKey;
  }
  if (twice && apart >= kLeast && apart <= kMost) {
    switches_.order_arm();
    return kArmKey;
  }
  pressed_once_ = true;
  return kFirstArmKey;
}

}  // namespace tactus::app
