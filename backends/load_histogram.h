#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace tactus {

/// How often which load occurred, in steps of a 16th of an octave from 2^-20 to 2^6: quantiles within 3 %.
/// Written on one real-time thread, read on any other.
class LoadHistogram {
 public:
  /// [realtime, one thread] What lies outside counts at the edge.
  void add(double load) noexcept {
    const double step = load > 0.0 ? (std::log2(load) + kOctavesBelow) * kSteps : 0.0;
    auto& counter = counts_[static_cast<std::size_t>(std::clamp(step, 0.0, kCounts - 1.0))];
    counter.store(counter.load(kRelaxed) + 1, kRelaxed);
  }
  /// [any] The load that a share `q` of all blocks does not exceed, 0 <= q <= 1; 0 if there were none.
  double quantile(double q) const noexcept {
    std::int64_t all = 0;
    for (const auto& count : counts_) all += count.load(kRelaxed);
    if (all == 0) return 0.0;
    const auto wanted = std::max<std::int64_t>(1, std::llround(std::ceil(q * static_cast<double>(all))));
    std::size_t i = 0;
    for (std::int64_t below = 0; i < kCounts; ++i)
      if ((below += counts_[i].load(kRelaxed)) >= wanted) break;
    return std::exp2((static_cast<double>(i) + 0.5) / kSteps - kOctavesBelow);
  }

 private:
  static constexpr auto kRelaxed = std::memory_order_relaxed;
  static constexpr double kSteps = 16.0, kOctavesBelow = 20.0;
  static constexpr std::size_t kCounts = 26 * 16;
  std::array<std::atomic<std::int64_t>, kCounts> counts_{};
};

}  // namespace tactus
