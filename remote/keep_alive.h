#pragma once
// Thread: [any]

#include <atomic>
#include <chrono>
#include <cstdint>

namespace tactus {

/// Watches the client that had the drives armed: a network thread refreshes it, and the stop loop, which no
/// other thread can block, asks whether it expired. It is void when the drives were disarmed meanwhile:
/// whoever arms them then is not that client.
class KeepAlive {
 public:
  using Clock = std::chrono::steady_clock;
  static constexpr std::chrono::milliseconds kPatience{500};

  /// [any, the network thread] `disarms`: how often the drives were disarmed so far, by whomever.
  void begin(Clock::time_point now, int disarms) noexcept {
    disarms_ = disarms;
    last_ = ticks(now);
  }
  /// [any, the network thread] Only while it is watched, for the arming that began with so many `disarms`:
  /// what expired stays so.
  void refresh(Clock::time_point now, int disarms) noexcept {
    auto last = last_.load();
    if (disarms != disarms_) return;
    while (last != kNobody && !last_.compare_exchange_weak(last, ticks(now))) continue;
  }
  /// [any, the stop loop] True once, when a client is watched that was not heard of for kPatience.
  bool expired(Clock::time_point now, int disarms) noexcept {
    auto last = last_.load();
    if (last == kNobody) return false;
    if (disarms != disarms_) {
      last_.compare_exchange_strong(last, kNobody);  // unless another client has begun
      return false;
    }
    // A refresh that comes meanwhile wins.
    return ticks(now) - last >= kPatience_ns && last_.compare_exchange_strong(last, kNobody);
  }

 private:
  static constexpr std::int64_t kNobody = 0;
  static constexpr std::int64_t kPatience_ns = std::chrono::nanoseconds{kPatience}.count();
  static std::int64_t ticks(Clock::time_point time) noexcept {
    return std::chrono::nanoseconds{time.time_since_epoch()}.count();
  }

  std::atomic<std::int64_t> last_{kNobody};
  std::atomic<int> disarms_{0};
};

}  // namespace tactus
