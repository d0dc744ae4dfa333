#pragma once
// Thread: [any, one thread]

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

namespace tactus {

/// How fast reports are sent to a force-feedback device. A USB device takes one every 1 ms or 2 ms. The
/// system queues what is sent faster, which then comes late, and drops what no longer fits, Linux after 256
/// reports: also a report that stops an effect.
class ReportBudget {
 public:
  using Clock = std::chrono::steady_clock;

  static constexpr std::chrono::milliseconds kInterval{2};  ///< of a report, on average

  bool allows(Clock::time_point now) const { return now >= free_; }
  void spend(int reports, Clock::time_point now) { free_ = std::max(free_, now) + reports * kInterval; }

 private:
  Clock::time_point free_;
};

/// When an effect of a force-feedback device is sent, for a level that changes all the time. An effect lasts
/// kLength in the device and is started again well before its end: a program that hangs, or a cable that is
/// pulled, ends it.
class EffectTimer {
 public:
  using Clock = std::chrono::steady_clock;

  static constexpr std::chrono::milliseconds kLength{500};   ///< of an effect in the device
  static constexpr std::chrono::milliseconds kRestart{200};  ///< it is started again after at least this
  static constexpr double kStep = 1.0 / 32767;               ///< of a level

  enum class Order { None, Start, Change, Restart, Stop };

  /// What is to be sent for this level, from -1 to 1; it counts as sent. `allowed`: the device takes a report
  /// now; a stop does not wait for that. `changes`: something else than the level does. `restart`: an effect
  /// is started again after this.
  Order next(double level, Clock::time_point now, bool allowed, bool changes = false,
             std::chrono::milliseconds restart = kRestart) {
    const bool silent = std::abs(level) < kStep;
    if (silent) return std::exchange(runs_, false) ? Order::Stop : Order::None;
    if (!allowed) return Order::None;
    const bool starts = !std::exchange(runs_, true);
    if (starts || now - started_ >= restart) {
      started_ = now;
      level_ = level;
      return starts ? Order::Start : Order::Restart;
    }
    if (!changes && std::abs(level - level_) < kStep) return Order::None;
    level_ = level;
    return Order::Change;
  }

 private:
  bool runs_ = false;
  double level_ = 0.0;  ///< in the device
  Clock::time_point started_;
};

}  // namespace tactus
