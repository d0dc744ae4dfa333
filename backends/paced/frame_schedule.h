#pragma once
// Thread: [any, one thread]

#include <algorithm>
#include <chrono>
#include <cstdint>

namespace tactus {

/// When the frames of a loop that processes one frame a call are due. Frame k is due at t_k = t_0 + k / rate.
/// Woken at the time w, the loop processes the latest frame that is due,
///   j = max(k, floor((w - t_0) rate)),
/// where k follows the frame before. Frames k to j - 1 are skipped: no period has two frames, however late
/// the loop is. The lateness is w - t_k. Exact to the nanosecond for any number of frames.
class FrameSchedule {
 public:
  using Time = std::chrono::nanoseconds;  ///< since any instant

  struct Turn {
    std::int64_t frame = 0;    ///< to process now
    std::int64_t skipped = 0;  ///< frames before it that are left out
    Time late{0};
  };

  /// `rate_hz` > 0. `begin`: when frame 0 is due.
  FrameSchedule(int rate_hz, Time begin) : rate_(rate_hz), begin_(begin) {}

  Time due(std::int64_t frame) const noexcept {
    const auto rest = frame % rate_ * kSecond;
    return begin_ + Time{frame / rate_ * kSecond + (rest + rate_ - 1) / rate_};
  }
  Time next_due() const noexcept { return due(next_); }
  /// The loop, which waited for `next_due`, goes on at `now`.
  Turn wake(Time now) noexcept {
    const auto late = std::max(Time{0}, now - next_due());
    const auto frame = std::max(next_, frame_at(now));
    const Turn turn{frame, frame - next_, late};
    next_ = frame + 1;
    return turn;
  }

 private:
  static constexpr std::int64_t kSecond = 1'000'000'000;

  /// The latest that is due.
  std::int64_t frame_at(Time now) const noexcept {
    const auto since = (now - begin_).count();
    return since / kSecond * rate_ + since % kSecond * rate_ / kSecond;
  }

  std::int64_t rate_;
  Time begin_;
  std::int64_t next_ = 0;
};

}  // namespace tactus
