#include "apps/play/live/controls/drive_keys.h"

#include <utility>

namespace tactus::app {

Key DriveKeys::act(Key key, Clock::time_point now) {
  notice_disarm(now);
  if (key == 'a') return press_arm(now);
  if (state_ != State::Pause) state_ = State::Idle;
  if (key != 'm') return key;
  switches_.mute(!switches_.muted());
  return switches_.muted() ? kMutedKey : kUnmutedKey;
}

Key DriveKeys::act_later(Clock::time_point now) {
  notice_disarm(now);
  if (state_ != State::PressedTwice || now - pressed_at_ < kNothingAfter) return kNoKey;
  state_ = State::Idle;
  switches_.order_arm();
  return kArmKey;
}

Key DriveKeys::press_arm(Clock::time_point now) {
  const auto apart = now - std::exchange(pressed_at_, now);
  const auto quiet = now - std::exchange(quiet_since_, now);
  if (!switches_.armed() && !switches_.arm_ordered()) return count_press(apart, quiet);
  switches_.disarm();
  notice_disarm(now);
  return kDisarmedKey;
}

/// Of the presses while the drives are disarmed.
Key DriveKeys::count_press(Clock::duration apart, Clock::duration quiet) {
  const bool repeats = apart < kLeast;
  if (state_ == State::Pause && quiet < kPause) return repeats ? kNoKey : kNotArmedKey;
  if (state_ == State::PressedTwice || (state_ == State::PressedOnce && repeats)) {
    state_ = State::Pause;
    return kNotArmedKey;
  }
  state_ = state_ == State::PressedOnce && apart <= kMost ? State::PressedTwice : State::PressedOnce;
  return state_ == State::PressedOnce ? kFirstArmKey : kNoKey;
}

/// Whoever presses a at that moment may want to disarm.
void DriveKeys::notice_disarm(Clock::time_point now) {
  const int disarms = switches_.disarms();
  if (std::exchange(disarms_, disarms) == disarms) return;
  state_ = State::Pause;
  quiet_since_ = now;
}

}  // namespace tactus::app
