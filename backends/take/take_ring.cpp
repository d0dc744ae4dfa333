#include "backends/take/take_ring.h"

#include <algorithm>

#include "engine/core/index.h"

namespace tactus {
namespace {

constexpr auto kRelaxed = std::memory_order_relaxed;

}  // namespace

TakeRing::TakeRing(int in_channels, int out_channels, std::int64_t frames)
    : in_channels_(in_channels),
      out_channels_(out_channels),
      capacity_(frames),
      samples_(index(frames) * index(channels())) {}

void TakeRing::applied(const JournalEntry& entry) noexcept {
  // Frames only ever grow, until somebody prepares the stream anew.
  if (entry.frame < next_frame_) restarted_.store(true, kRelaxed);
  if (restarted()) return;
  if (!events_.push(entry)) lost_entries_.fetch_add(1, kRelaxed);
}

void TakeRing::observe(const BlockIo& io, std::int64_t first_frame) noexcept {
  if (first_frame < next_frame_) restarted_.store(true, kRelaxed);
  if (restarted()) return;
  if (gap_.frames == 0) gap_ = {next_frame_, first_frame - next_frame_};  // not there from the beginning
  if (has_room(io.frames) && close_gap()) {
    const auto at = written_.load(kRelaxed);
    copy(io, at);
    written_.store(at + io.frames, std::memory_order_release);
  } else {
    gap_.frames += io.frames;
    dropped_.fetch_add(io.frames, kRelaxed);
  }
  next_frame_ = first_frame + io.frames;
}

bool TakeRing::has_room(int frames) noexcept {
  return written_.load(kRelaxed) - read_.load(std::memory_order_acquire) + frames <= capacity_;
}

/// A gap must be known before what follows it.
bool TakeRing::close_gap() noexcept {
  if (gap_.frames > 0 && !events_.push(gap_)) return false;
  gap_ = {};
  return true;
}

void TakeRing::copy(const BlockIo& io, std::int64_t at) noexcept {
  const auto width = index(channels());
  std::int64_t rounded = 0;
  for (int done = 0; done < io.frames;) {
    const auto slot = (at + done) % capacity_;
    const int frames = static_cast<int>(std::min<std::int64_t>(io.frames - done, capacity_ - slot));
    float* to = samples_.data() + index(slot) * width;
    for (int c = 0; c < in_channels_; ++c, ++to)
      for (int n = 0; n < frames; ++n) {
        const double sensor = io.in[c][done + n];
        const auto kept = static_cast<float>(sensor);
        rounded += static_cast<double>(kept) == sensor ? 0 : 1;
        to[index(n) * width] = kept;
      }
    for (int c = 0; c < out_channels_; ++c, ++to)
      for (int n = 0; n < frames; ++n) to[index(n) * width] = as_recorded(io.out[c][done + n]);
    done += frames;
  }
  if (rounded > 0) rounded_.fetch_add(rounded, kRelaxed);
}

TakeRing::Segment TakeRing::front(std::int64_t written) const noexcept {
  const auto read = read_.load(kRelaxed);
  const auto slot = read % capacity_;
  return {samples_.data() + index(slot) * index(channels()), std::min(written - read, capacity_ - slot)};
}

}  // namespace tactus
