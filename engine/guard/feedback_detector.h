#pragma once

#include <cstdint>
#include <vector>

#include "engine/core/units.h"
#include "engine/guard/guard_group.h"

namespace tactus {

/// Detects an unstable loop through a drive: it does not stop at the limits by itself, so the guard limits
/// every period. A frame counts as limited for a while after, because a loop may touch the limit only at its
/// peaks. More than half of the last 200 ms limited is feedback.
class FeedbackDetector {
 public:
  static constexpr Seconds kWindow{0.2};

  /// [control]
  explicit FeedbackDetector(Hertz sample_rate)
      : window_(static_cast<std::size_t>(frames_in(kWindow, sample_rate) / kGuardGroup) + 1) {}

  /// [realtime] The drive was limited at `frame`, which counts for `hold` frames.
  void limited(std::int64_t frame, std::int64_t hold) noexcept {
    if (frame + hold > until_) until_ = frame + hold;
  }
  /// [realtime] The group before `frame` is over. True: feedback.
  bool end_group(std::int64_t frame) noexcept {
    const bool busy = until_ > frame - kGuardGroup;
    if (!busy && count_ == 0) return false;
    auto& oldest = window_[next_];
    if (oldest) --count_;
    if (busy) ++count_;
    oldest = busy;
    next_ = next_ + 1 == window_.size() ? 0 : next_ + 1;
    return 2 * count_ > window_.size();
  }
  /// [realtime]
  void forget() noexcept {
    for (auto& busy : window_) busy = false;
    count_ = 0;
    until_ = 0;
  }

 private:
  std::vector<unsigned char> window_;  ///< of each group: was it limited
  std::size_t next_ = 0, count_ = 0;
  std::int64_t until_ = 0;
};

}  // namespace tactus
