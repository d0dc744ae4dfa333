#pragma once

#include <atomic>
#include <cstdint>

namespace tactus {

/// How a stream fares, counted since it was opened.
struct Health {
  std::int64_t blocks = 0;
  std::int64_t frames = 0;
  std::int64_t xruns = 0;        ///< times that the driver reported a gap
  std::int64_t lost_frames = 0;  ///< frames missing in those gaps, as far as they are known
  std::int64_t bad_input = 0;    ///< input samples that were NaN or infinite and became 0
  int shortest_block = 0;        ///< [frames]
  int longest_block = 0;         ///< [frames]
  double mean_load = 0.0;        ///< time in `process` over the block's duration
  double peak_load = 0.0;        ///< above 1 the block came late

  bool operator==(const Health&) const = default;
};

/// Counted on the real-time thread, read on any other. Each number is whole, but they may be of neighbouring
/// blocks: health is for people to look at, not for decisions that must agree.
class HealthMeter {
 public:
  /// [realtime, one thread] `load`: time in `process` over the block's duration; 0 where no clock is looked
  /// at.
  void block(int frames, double load) noexcept {
    add(blocks_, 1);
    add(frames_, frames);
    if (const int least = shortest_.load(kRelaxed); least == 0 || frames < least)
      shortest_.store(frames, kRelaxed);
    if (frames > longest_.load(kRelaxed)) longest_.store(frames, kRelaxed);
    load_sum_.store(load_sum_.load(kRelaxed) + load, kRelaxed);
    if (load > peak_load_.load(kRelaxed)) peak_load_.store(load, kRelaxed);
  }
  /// [realtime, any thread] `lost_frames` 0: not known.
  void xrun(std::int64_t lost_frames) noexcept {
    xruns_.fetch_add(1, kRelaxed);
    lost_.fetch_add(lost_frames, kRelaxed);
  }
  /// [realtime, one thread]
  void bad_input(std::int64_t samples) noexcept { add(bad_input_, samples); }

  /// [any]
  Health read() const noexcept {
    Health health;
    health.blocks = blocks_.load(kRelaxed);
    health.frames = frames_.load(kRelaxed);
    health.xruns = xruns_.load(kRelaxed);
    health.lost_frames = lost_.load(kRelaxed);
    health.bad_input = bad_input_.load(kRelaxed);
    health.shortest_block = shortest_.load(kRelaxed);
    health.longest_block = longest_.load(kRelaxed);
    if (health.blocks > 0) health.mean_load = load_sum_.load(kRelaxed) / static_cast<double>(health.blocks);
    health.peak_load = peak_load_.load(kRelaxed);
    return health;
  }

 private:
  static constexpr auto kRelaxed = std::memory_order_relaxed;
  // One thread writes: a load and a store are cheaper than a locked addition.
  static void add(std::atomic<std::int64_t>& counter, std::int64_t more) noexcept {
    counter.store(counter.load(kRelaxed) + more, kRelaxed);
  }

  std::atomic<std::int64_t> blocks_{0}, frames_{0}, xruns_{0}, lost_{0}, bad_input_{0};
  std::atomic<int> shortest_{0}, longest_{0};
  std::atomic<double> load_sum_{0.0}, peak_load_{0.0};
};

}  // namespace tactus
