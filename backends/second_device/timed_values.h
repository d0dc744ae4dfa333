#pragma once
// Thread: [any, one producer and one consumer]

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "engine/core/spsc_queue.h"

namespace tactus {

/// Values over time, from the thread of one device to that of another, which runs at its own rate. The reader
/// asks for times that lie so far back that both points around them are known. Between two points a value
/// moves in a straight line, after the last one it rests.
class TimedValues {
 public:
  static constexpr std::size_t kMost = 32;  ///< values of a point
  struct Point {
    double seconds = 0.0;
    std::array<double, kMost> values = {};
  };

  /// [producer] Points in order of their time. If the queue is full, because the reader has not read for a
  /// quarter of a second, the point is dropped.
  void write(const Point& point) noexcept { (void)points_.push(point); }

  /// [consumer] The two points around this time, which never goes back; `at` refers to them.
  void advance(double seconds) noexcept {
    while (after_.seconds < seconds) {
      const auto* next = points_.front();
      if (next == nullptr) break;
      before_ = started_ ? after_ : *next;
      after_ = *next;
      started_ = true;
      points_.drop_front();
    }
  }
  /// [consumer] Of a time not after that of `advance`, nor before the one of the call before it.
  double at(std::size_t value, double seconds) const noexcept {
    const double length = after_.seconds - before_.seconds;
    const double share = length > 0 ? std::clamp((seconds - before_.seconds) / length, 0.0, 1.0) : 1.0;
    return std::lerp(before_.values[value], after_.values[value], share);
  }
  /// [consumer] The last point.
  double newest() const noexcept { return after_.seconds; }

 private:
  SpscQueue<Point> points_{256};
  Point before_{-kForEver, {}}, after_{-kForEver, {}};
  bool started_ = false;
  static constexpr double kForEver = 1e300;
};

/// When the frames of a device happen, by the clock of the computer. Blocks come irregularly, frames do not:
/// the start of a block is where the one before ended, moved by a twentieth of the difference to when it
/// came. A jump by more than 50 ms is followed at once.
class BlockClock {
 public:
  explicit BlockClock(double rate_hz) : rate_(rate_hz) {}

  /// The time of the first frame of a block that came now.
  double start(double now_seconds, int frames) noexcept {
    const double late = now_seconds - next_;
    const double begin = std::abs(late) > kJump ? now_seconds : next_ + kShare * late;
    next_ = begin + frames / rate_;
    return begin;
  }

 private:
  static constexpr double kJump = 0.05, kShare = 0.05;
  double rate_;
  double next_ = -1e300;
};

}  // namespace tactus
