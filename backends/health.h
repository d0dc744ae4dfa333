#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace tactus {

/// Who noticed a gap in the sound, and where it is.
enum class Gap : std::uint8_t {
  Input,   ///< the driver had to drop what came in
  Output,  ///< the driver ran out of what goes out
  Server,  ///< the sound server reported a late client
  Unsaid,  ///< not reported, but frames are missing
};
inline constexpr std::size_t kGaps = 4;
/// [any] "input", "output", "server", "unsaid".
inline const char* name_of(Gap gap) {
  constexpr std::array<const char*, kGaps> kNames{"input", "output", "server", "unsaid"};
  return kNames[static_cast<std::size_t>(gap)];
}

/// How a stream fares, counted since it was opened.
struct Health {
  std::int64_t blocks = 0;
  std::int64_t frames = 0;
  double seconds = 0.0;                    ///< from the first block to the latest; 0: no clock is used
  std::int64_t xruns = 0;                  ///< gaps of all causes
  std::array<std::int64_t, kGaps> gaps{};  ///< of them, by Gap
  std::int64_t lost_frames = 0;            ///< frames missing in those gaps, as far as they are known
  std::int64_t late_blocks = 0;            ///< that took longer to make than they last
  std::int64_t bad_input = 0;              ///< input samples that were NaN or infinite and became 0
  int shortest_block = 0;                  ///< [frames]
  int longest_block = 0;                   ///< [frames]
  double mean_load = 0.0;                  ///< time in `process` over the block's duration
  double median_load = 0.0;                ///< p50, within 1.6 %
  double high_load = 0.0;                  ///< p99.9, within 1.6 %
  double peak_load = 0.0;                  ///< above 1 the block came late
  int realtime_priority = 0;               ///< of the thread that brings the blocks; 0: an ordinary thread

  bool operator==(const Health&) const = default;
};

/// [any] Both one after the other. The quantiles of the load cannot be joined: they are those of `after`,
/// where it has any blocks.
inline Health together(const Health& before, const Health& after) {
  if (after.blocks == 0 && after.xruns == 0) return before;
  if (before.blocks == 0 && before.xruns == 0) return after;
  Health both = after;
  for (const auto counter : {&Health::blocks, &Health::frames, &Health::xruns, &Health::lost_frames,
                             &Health::late_blocks, &Health::bad_input})
    both.*counter += before.*counter;
  both.seconds += before.seconds;
  for (std::size_t g = 0; g < kGaps; ++g) both.gaps[g] += before.gaps[g];
  if (before.blocks > 0)
    both.shortest_block =
        after.blocks > 0 ? std::min(before.shortest_block, after.shortest_block) : before.shortest_block;
  both.longest_block = std::max(before.longest_block, after.longest_block);
  if (both.blocks > 0)
    both.mean_load = (before.mean_load * static_cast<double>(before.blocks) +
                      after.mean_load * static_cast<double>(after.blocks)) /
                     static_cast<double>(both.blocks);
  both.peak_load = std::max(before.peak_load, after.peak_load);
  return both;
}

/// How often which load occurred, from 2^-20 to 2^6, each octave in 32 equal steps, which are the upper bits
/// of the number: quantiles within 1.6 %. Written on one real-time thread, read on any other.
class LoadHistogram {
 public:
  /// [realtime, one thread] What lies outside counts at the edge.
  void add(double load) noexcept {
    auto& counter = counts_[load > kLeast ? std::min<std::uint64_t>(step_of(load) - kFirst, kCounts - 1) : 0];
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
    return std::bit_cast<double>((2 * (kFirst + i) + 1) << (kShift - 1));
  }

 private:
  static constexpr auto kRelaxed = std::memory_order_relaxed;
  static constexpr int kShift = 47;  ///< the sign, the exponent and five bits of the fraction remain
  static std::uint64_t step_of(double load) noexcept { return std::bit_cast<std::uint64_t>(load) >> kShift; }
  static constexpr double kLeast = 0x1p-20;
  static constexpr std::uint64_t kFirst = std::bit_cast<std::uint64_t>(kLeast) >> kShift;
  static constexpr std::size_t kCounts = 26 * 32;
  std::array<std::atomic<std::int64_t>, kCounts> counts_{};
};

/// Counted on the real-time thread, read on any other. Each number is whole, but they may be of neighbouring
/// blocks: health is for display, not for decisions that must agree.
class HealthMeter {
 public:
  /// [realtime, one thread] `load`: time in `process` over the block's duration; 0 where no clock is used.
  void block(int frames, double load) noexcept {
    add(blocks_, 1);
    add(frames_, frames);
    if (const int least = shortest_.load(kRelaxed); least == 0 || frames < least)
      shortest_.store(frames, kRelaxed);
    if (frames > longest_.load(kRelaxed)) longest_.store(frames, kRelaxed);
    load_sum_.store(load_sum_.load(kRelaxed) + load, kRelaxed);
    if (load > peak_load_.load(kRelaxed)) peak_load_.store(load, kRelaxed);
    if (load > 1.0) add(late_, 1);
    loads_.add(load);
  }
  /// [realtime, one thread] The block that comes next begins at `seconds` since the first one did.
  void clock(double seconds) noexcept { seconds_.store(seconds, kRelaxed); }
  /// [realtime, any thread]
  void gap(Gap gap) noexcept { gaps_[static_cast<std::size_t>(gap)].fetch_add(1, kRelaxed); }
  /// [realtime, any thread] They went missing in a gap that is counted.
  void lost(std::int64_t frames) noexcept { lost_.fetch_add(frames, kRelaxed); }
  /// [realtime, one thread]
  void realtime_priority(int priority) noexcept { priority_.store(priority, kRelaxed); }
  /// [realtime, one thread]
  void bad_input(std::int64_t samples) noexcept { add(bad_input_, samples); }

  /// [any]
  Health read() const noexcept {
    Health health;
    health.blocks = blocks_.load(kRelaxed);
    health.frames = frames_.load(kRelaxed);
    health.seconds = seconds_.load(kRelaxed);
    for (std::size_t g = 0; g < kGaps; ++g) health.xruns += health.gaps[g] = gaps_[g].load(kRelaxed);
    health.lost_frames = lost_.load(kRelaxed);
    health.bad_input = bad_input_.load(kRelaxed);
    health.shortest_block = shortest_.load(kRelaxed);
    health.longest_block = longest_.load(kRelaxed);
    if (health.blocks > 0) health.mean_load = load_sum_.load(kRelaxed) / static_cast<double>(health.blocks);
    health.peak_load = peak_load_.load(kRelaxed);
    health.median_load = std::min(health.peak_load, loads_.quantile(0.5));  // a step may end above the peak
    health.high_load = std::min(health.peak_load, loads_.quantile(0.999));
    health.late_blocks = late_.load(kRelaxed);
    health.realtime_priority = priority_.load(kRelaxed);
    return health;
  }

 private:
  static constexpr auto kRelaxed = std::memory_order_relaxed;
  // One thread writes: a load and a store are cheaper than a locked addition.
  static void add(std::atomic<std::int64_t>& counter, std::int64_t more) noexcept {
    counter.store(counter.load(kRelaxed) + more, kRelaxed);
  }

  std::atomic<std::int64_t> blocks_{0}, frames_{0}, late_{0}, lost_{0}, bad_input_{0};
  std::array<std::atomic<std::int64_t>, kGaps> gaps_{};
  std::atomic<int> shortest_{0}, longest_{0}, priority_{0};
  std::atomic<double> seconds_{0.0}, load_sum_{0.0}, peak_load_{0.0};
  LoadHistogram loads_;
};

}  // namespace tactus
