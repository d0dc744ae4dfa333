#pragma once
// Thread: [control] unless stated otherwise; [writer]: the thread that reads the ring

#include <atomic>
#include <cstdint>
#include <variant>
#include <vector>

#include "backends/take/take.h"
#include "engine/core/spsc_queue.h"

namespace tactus {

/// Something besides samples that belongs into a take, in the order in which it happened: an entry that was
/// applied, or frames that were dropped.
using TakeEvent = std::variant<JournalEntry, TakeGap>;

/// Where the audio thread puts what a take needs, and a writer fetches it. Room for samples and events is
/// there from the beginning; when it is full, whole blocks are dropped and counted, and the gap is reported
/// once there is room again. Neither side ever waits.
class TakeRing final : public BlockTap {
 public:
  /// [control] Room for `frames` frames of `in_channels` + `out_channels` samples.
  TakeRing(int in_channels, int out_channels, std::int64_t frames);

  /// [realtime] Tap of Guarded and of Player.
  void applied(const JournalEntry& entry) noexcept TACTUS_NONBLOCKING override;
  void observe(const BlockIo& io, std::int64_t first_frame) noexcept TACTUS_NONBLOCKING override;

  /// Samples that lie one after the other, frame by frame: the inputs, then the outputs.
  struct Segment {
    const float* samples;
    std::int64_t frames;
  };
  /// [writer] How many frames were put in so far, gaps left out. All events of these frames are there too.
  std::int64_t written() const noexcept { return written_.load(std::memory_order_acquire); }
  /// [writer] The oldest of them, as many as lie together.
  Segment front(std::int64_t written) const noexcept;
  void drop_front(std::int64_t frames) noexcept {
    read_.store(read_.load(std::memory_order_relaxed) + frames, std::memory_order_release);
  }
  [[nodiscard]] bool pop(TakeEvent& event) noexcept { return events_.pop(event); }
  /// [writer & stream stopped] A gap that no block followed; 0 frames: none.
  const TakeGap& open_gap() const noexcept { return gap_; }

  int channels() const noexcept { return in_channels_ + out_channels_; }
  /// [any] Frames that were dropped, entries that were, sensor samples that were no float32.
  std::int64_t dropped_frames() const noexcept { return dropped_.load(std::memory_order_relaxed); }
  std::int64_t lost_entries() const noexcept { return lost_entries_.load(std::memory_order_relaxed); }
  std::int64_t rounded_sensors() const noexcept { return rounded_.load(std::memory_order_relaxed); }
  /// [any] The stream began again at frame 0; what it did from there on is not recorded.
  bool restarted() const noexcept { return restarted_.load(std::memory_order_relaxed); }

 private:
  bool has_room(int frames) noexcept;
  bool close_gap() noexcept;
  void copy(const BlockIo& io, std::int64_t at) noexcept;

  int in_channels_, out_channels_;
  std::int64_t capacity_;  ///< frames
  std::vector<float> samples_;
  SpscQueue<TakeEvent> events_{16384};
  std::atomic<std::int64_t> written_{0}, read_{0};  ///< frames since the beginning
  std::atomic<std::int64_t> dropped_{0}, lost_entries_{0}, rounded_{0};
  std::atomic<bool> restarted_{false};
  // Audio side.
  std::int64_t next_frame_ = 0;  ///< of the stream
  TakeGap gap_;
};

}  // namespace tactus
