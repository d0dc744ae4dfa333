#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace tactus {

/// How often which time occurred, in steps of 1 us up to 10 ms; what is longer is counted together. Written
/// on one real-time thread, read on any other.
class LatenessHistogram {
 public:
  static constexpr int kBins = 10'000;
  using Time = std::chrono::nanoseconds;

  /// [realtime, one thread] Below 0 counts as 0.
  void add(Time time) noexcept {
    const auto bin = std::clamp<std::int64_t>(time.count() / 1000, 0, kBins);
    auto& counter = counts_[static_cast<std::size_t>(bin)];
    counter.store(counter.load(kRelaxed) + 1, kRelaxed);
    if (time.count() > longest_.load(kRelaxed)) longest_.store(time.count(), kRelaxed);
  }
  /// [any] How many were from `us` to below `us` + 1; `kBins`: 10 ms or more.
  std::int64_t count(int us) const noexcept { return counts_[static_cast<std::size_t>(us)].load(kRelaxed); }
  /// [any]
  std::int64_t total() const noexcept {
    std::int64_t all = 0;
    for (const auto& count : counts_) all += count.load(kRelaxed);
    return all;
  }
  /// [any]
  Time longest() const noexcept { return Time{longest_.load(kRelaxed)}; }
  /// [any] The time that a share `q` of all does not exceed, 0 <= q <= 1, rounded up to 1 us; the longest
  /// where that is shorter, or where the time is above 10 ms; 0 if there were none.
  Time quantile(double q) const noexcept {
    const auto all = total();
    const auto wanted = std::max<std::int64_t>(1, std::llround(std::ceil(q * static_cast<double>(all))));
    std::int64_t below = 0;
    for (int us = 0; us < kBins && all > 0; ++us)
      if ((below += count(us)) >= wanted) return std::min(longest(), Time{1000 * (us + 1)});
    return longest();
  }

 private:
  static constexpr auto kRelaxed = std::memory_order_relaxed;
  std::array<std::atomic<std::int64_t>, kBins + 1> counts_{};
  std::atomic<std::int64_t> longest_{0};
};

}  // namespace tactus
