#include "backends/card_callback.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <thread>

#include "backends/realtime_thread.h"
#include "engine/core/every_block.h"
#include "engine/core/index.h"

namespace tactus {
namespace {

constexpr std::chrono::milliseconds kStall{500};
constexpr std::int64_t kUnknownGap = std::int64_t{1} << 32;  ///< in frames: longer than any mass remembers

double seconds(std::chrono::steady_clock::duration time) {
  return std::chrono::duration<double>(time).count();
}

/// `blocks` of the granted ones.
std::chrono::nanoseconds duration_of(int blocks, int block_frames, const StreamGranted& granted) {
  return std::chrono::nanoseconds{
      std::llround(1e9 * blocks * block_frames / granted.format.sample_rate.value)};
}

}  // namespace

/// Returns how many samples were not finite, and became 0.
static int copy_finite(const float* plane, double* samples, int frames) noexcept {
  constexpr std::uint32_t kExponent = 0x7f800000;  // all ones: infinite, or no number
  std::uint32_t highest = 0;
  for (int n = 0; n < frames; ++n) {
    samples[n] = static_cast<double>(plane[n]);
    highest = std::max(highest, std::bit_cast<std::uint32_t>(plane[n]) & kExponent);
  }
  if (highest < kExponent) [[likely]]
    return 0;
  int bad = 0;
  for (int n = 0; n < frames; ++n)
    if (!std::isfinite(samples[n])) samples[n] = 0.0, ++bad;
  return bad;
}

CardCallback::CardCallback(GuardedBlocks& processor, const StreamRequest& request,
                           const StreamGranted& granted)
    : processor_(processor),
      format_(granted.format),
      patience_(
          std::max<std::chrono::nanoseconds>(kStall, duration_of(4, granted.format.max_frames, granted))),
      lost_patience_(std::chrono::milliseconds{20} + duration_of(4, granted.format.max_frames, granted)),
      stopped_patience_(lost_patience_ + std::chrono::milliseconds{80}),
      buffer_(duration_of(granted.periods, granted.block_frames, granted)),
      in_map_(channels_of(request.in_map, granted.format.in_channels)),
      out_map_(channels_of(request.out_map, granted.format.out_channels)),
      clock_(granted.format.sample_rate.value) {
  in_.resize(static_cast<int>(in_map_.size()), format_.max_frames);
  out_.resize(static_cast<int>(out_map_.size()), format_.max_frames);
  last_block_ = Clock::now();
}

// No block is being played, so no other thread reads the clock.
void CardCallback::play() noexcept {
  clock_ = FrameWatch{format_.sample_rate.value};
  frames_ = 0;
  zeros_.store(0);
  last_block_ = Clock::now();
  stage_.store(Stage::Playing);
}

bool CardCallback::finish(bool lost) {
  auto expected = Stage::Playing;
  if (!stage_.compare_exchange_strong(expected, Stage::Finishing)) return true;
  const std::chrono::duration<double> closing{processor_.closing_time().value};
  const auto begin = Clock::now();
  const auto deadline = begin + patience_ + std::chrono::duration_cast<Clock::duration>(closing);
  while (stage_.load() == Stage::Finishing) {
    const auto now = Clock::now();
    const auto silence = now - std::max(begin, last_block_.load());
    if (now > deadline || silence > (lost ? lost_patience_ : stopped_patience_)) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds{1});
  }
  if (lost)
    std::this_thread::sleep_for(lost_patience_ + buffer_);  // the library closes at once, and drops it
  return true;
}

// `block` sets busy_ before it reads the stage, so one of the two threads sees the other.
void CardCallback::abandon() noexcept {
  stage_.store(Stage::Silent);
  while (busy_.load()) std::this_thread::yield();
}

void CardCallback::fill_with_zeros(std::int64_t frames) const {
  std::int64_t before = -1;
  for (auto changed = Clock::now(); zeros_.load() < frames && Clock::now() - changed < kStall;) {
    if (const auto now = zeros_.load(); std::exchange(before, now) != now) changed = Clock::now();
    std::this_thread::sleep_for(std::chrono::milliseconds{1});
  }
}

TACTUS_EVERY_BLOCK void CardCallback::block(const float* const* in, float* const* out, int device_outputs,
                                            int frames) noexcept {
  busy_.store(true);
  const auto stage = stage_.load();
  for (int c = 0; c < device_outputs; ++c)
    if (out[c] != nullptr) std::fill_n(out[c], std::max(0, frames), 0.0f);
  const auto begin = Clock::now();
  // After a stall or a suspension the outputs must not jump back to full level.
  const auto pause = begin - last_block_.load(std::memory_order_relaxed);
  const bool late = pause > patience_;
  const bool suspended = stage == Stage::Playing && suspended_.load();
  if (late && stage == Stage::Playing && !suspended) processor_.note_pause(Seconds{seconds(pause)});
  if (late) gap_frames_.store(kUnknownGap, std::memory_order_relaxed);
  if (suspended) skip(begin);
  const bool wanted = stage != Stage::Silent && frames > 0;
  if (stage == Stage::Silent) zeros_.fetch_add(std::max(0, frames), std::memory_order_relaxed);
  if (wanted && !suspended) watch(frames, begin);
  const bool pauses = suspended || (stage == Stage::Playing && clock_.ahead());
  if (wanted && !(pauses && paused_)) {
    if (std::exchange(first_, false)) {
      use_stack();
      meter_.realtime_priority(realtime_priority());
    }
    if (stage == Stage::Playing && first_block_ == Clock::time_point{}) first_block_ = begin;
    resumes_ = stage == Stage::Playing && (resumes_ || pauses || late);
    if (stage == Stage::Playing) meter_.clock(seconds(begin - first_block_));
    if (gap_frames_.load(std::memory_order_relaxed) > 0 && stage == Stage::Playing)
      processor_.note_gap(gap_frames_.exchange(0, std::memory_order_relaxed));
    bool at_zero = true;
    for (int offset = 0; offset < frames; offset += format_.max_frames)
      at_zero = process(in, out, offset, std::min(format_.max_frames, frames - offset),
                        resumes_ ? Stage::Finishing : stage);
    resumes_ = resumes_ && !at_zero;
    paused_ = pauses && at_zero;
    const std::chrono::duration<double> took = Clock::now() - begin;
    if (stage == Stage::Playing) meter_.block(frames, took.count() * format_.sample_rate.value / frames);
    if (stage == Stage::Finishing && at_zero) stage_.store(Stage::Silent);
  }
  busy_.store(false);
}

void CardCallback::restart_from_zero() noexcept {
  busy_.store(true);
  const BlockIo io{in_.data(), out_.data(), format_.max_frames};
  // Twice what the guards need, should one never say that it is at zero.
  auto left = 2 * static_cast<std::int64_t>(frames_in(processor_.closing_time(), format_.sample_rate));
  bool at_zero = stage_.load() != Stage::Playing;
  for (; !at_zero && left >= 0; left -= format_.max_frames) at_zero = processor_.finish(io);
  busy_.store(false);
}

/// Frames do not run at their rate, so the clock finds none missing.
void CardCallback::skip(Clock::time_point now) noexcept {
  clock_ = FrameWatch{format_.sample_rate.value};
  last_block_.store(now, std::memory_order_relaxed);
}

/// True: when finishing, every output ends at zero.
TACTUS_EVERY_BLOCK bool CardCallback::process(const float* const* in, float* const* out, int offset,
                                              int frames, Stage stage) noexcept {
  convert_input(in, offset, frames);
  const BlockIo io{in_.data(), out_.data(), frames};
  bool at_zero = false;
  if (stage == Stage::Finishing)
    at_zero = processor_.finish(io);
  else
    processor_.process(io);
  for (int c = 0; c < out_.size(); ++c) {
    auto* plane = out[out_map_[index(c)]];
    if (plane == nullptr) continue;
    std::transform(out_[c], out_[c] + frames, plane + offset,
                   [](double sample) { return static_cast<float>(sample); });
  }
  return at_zero;
}

TACTUS_EVERY_BLOCK void CardCallback::convert_input(const float* const* in, int offset, int frames) noexcept {
  std::int64_t bad = 0;
  for (int c = 0; c < in_.size(); ++c) {
    const auto* plane = in == nullptr ? nullptr : in[in_map_[index(c)]];
    if (plane == nullptr)
      std::fill_n(in_[c], frames, 0.0);
    else
      bad += copy_finite(plane + offset, in_[c], frames);
  }
  if (bad > 0) meter_.bad_input(bad);
}

/// The clock finds missing frames at the end of the half second after a gap: if the library reported no gap
/// in that time, it missed it.
TACTUS_EVERY_BLOCK void CardCallback::watch(int frames, Clock::time_point now) noexcept {
  watch_buffer(now);
  last_block_.store(now, std::memory_order_relaxed);
  const auto missing = clock_.block(frames_, frames, seconds(now.time_since_epoch()));
  frames_ += frames;
  if (missing == 0) return;
  const double since_gap = seconds(now - last_gap_.load(std::memory_order_relaxed));
  if (since_gap > 3 * FrameWatch::kWindowSeconds) meter_.gap(Gap::Unsaid);
  meter_.lost(missing);
}

/// When a block begins later than the driver's buffer lasts after the one before, the buffer has run dry.
/// RtAudio tells ALSA to go on then and reports nothing: the blocks that follow come at once until none is
/// missing, and the clock finds nothing either.
TACTUS_EVERY_BLOCK void CardCallback::watch_buffer(Clock::time_point now) noexcept {
  const auto before = last_block_.load(std::memory_order_relaxed);
  if (frames_ == 0 || buffer_ == buffer_.zero() || now - before <= buffer_) return;
  if (last_gap_.load(std::memory_order_relaxed) < before) gap(Gap::Unsaid);
}

void CardCallback::lost(std::int64_t frames) noexcept {
  meter_.lost(frames);
  frames_ += frames;  // so that the clock does not count them again
  gap_frames_.fetch_add(frames, std::memory_order_relaxed);
}

void CardCallback::gap(Gap gap, GapLength length) noexcept {
  meter_.gap(gap);
  last_gap_.store(Clock::now(), std::memory_order_relaxed);
  if (length == GapLength::Unknown) gap_frames_.fetch_add(kUnknownGap, std::memory_order_relaxed);
}

bool CardCallback::stalled(std::chrono::milliseconds silence) const noexcept {
  return playing() && Clock::now() - last_block_.load(std::memory_order_relaxed) >
                          std::max<std::chrono::nanoseconds>(patience_, silence);
}

}  // namespace tactus
