#pragma once
// Thread: [any, one thread]

#include <chrono>
#include <cmath>
#include <utility>

namespace tactus {

/// When an effect of a force-feedback device is sent, for a level that changes all the time. An effect lasts
/// kLength in the device and is started again well before its end: a program that hangs, or a cable that is
/// pulled, ends it.
class EffectTimer {
 public:
  using Clock = std::chrono::steady_clock;

  static constexpr std::chrono::milliseconds kLength{500};   ///< of an effect in the device
  static constexpr std::chrono::milliseconds kRestart{200};  ///< it is started again after this
  static constexpr std::chrono::milliseconds kInterval{2};   ///< between two changes, at least
  static constexpr double kStep = 1.0 / 32767;               ///< of a level

  enum class Order { None, Start, Change, Restart, Stop };

  /// What is to be sent for this level, from -1 to 1; it counts as sent.
  Order next(double level, Clock::time_point now) {
    const bool silent = std::abs(level) < kStep;
    if (silent) return std::exchange(runs_, false) ? sent(0.0, now, Order::Stop) : Order::None;
    if (!runs_) {
      if (now - changed_ < kInterval) return Order::None;
      runs_ = true;
      started_ = now;
      return sent(level, now, Order::Start);
    }
    if (now - started_ >= kRestart) {
      started_ = now;
      return sent(level, now, Order::Restart);
    }
    const bool changes = std::abs(level - level_) >= kStep;
    return changes && now - changed_ >= kInterval ? sent(level, now, Order::Change) : Order::None;
  }

 private:
  Order sent(double level, Clock::time_point now, Order order) {
    level_ = level;
    changed_ = now;
    return order;
  }

  bool runs_ = false;
  double level_ = 0.0;  ///< in the device
  Clock::time_point changed_, started_;
};

}  // namespace tactus
