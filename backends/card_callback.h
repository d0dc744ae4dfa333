#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <utility>
#include <vector>

#include "backends/backend.h"
#include "backends/health.h"
#include "engine/core/channels.h"

namespace tactus {

/// Finds frames that went missing although no driver reported them, by the clock: blocks come late for many
/// reasons but never early, so the earliest block of each half second shows the stream's position. When it
/// falls behind that of the half second before by more than a block and by more than two clocks drift apart
/// (0.2 %), frames are missing.
///
/// Theory: with F frames brought until time t, e = F / rate - t is at most a constant while nothing is lost;
/// a loss of L frames lowers its maximum by L / rate. Where it rises by more than half a second above the
/// maximum of the half second before, frames run ahead of time: a server freewheels.
class FrameWatch {
 public:
  static constexpr double kWindowSeconds = 0.5;
  static constexpr double kDrift = 0.002;
  static constexpr double kAheadSeconds = 0.5;

  /// [any]
  explicit FrameWatch(double sample_rate_hz) : rate_(sample_rate_hz) {}

  /// [realtime] A block that begins at frame `frames` of the stream came at `seconds`. Returns how many
  /// frames were found missing.
  std::int64_t block(std::int64_t frames, int block_frames, double seconds) noexcept {
    const double early = static_cast<double>(frames) / rate_ - seconds;
    std::int64_t missing = 0;
    if (seconds >= window_end_) {
      const double fallen = before_ - earliest_;
      const double usual =
          std::max(block_frames / rate_, kDrift * (seconds - window_end_ + 2 * kWindowSeconds));
      if (fallen > usual) missing = std::llround(fallen * rate_);
      before_ = earliest_;
      earliest_ = kNever;
      window_end_ = seconds + kWindowSeconds;
    }
    earliest_ = std::max(earliest_, early);
    now_ = seconds;
    if (before_ != kNever && early > before_ + kAheadSeconds) ahead_until_ = seconds + 2 * kWindowSeconds;
    return missing;
  }
  /// [realtime] Frames run ahead of time, or did in the last second.
  bool ahead() const noexcept { return now_ < ahead_until_; }

 private:
  static constexpr double kNever = -std::numeric_limits<double>::infinity();

  double rate_;
  double window_end_ = kNever, before_ = kNever, earliest_ = kNever;
  double now_ = kNever, ahead_until_ = kNever;
};

/// The audio callback of every sound library: cuts a block that is longer than was granted, turns float32
/// into finite doubles, calls the processor and turns its outputs into float32. It holds nothing of the
/// library.
///
/// A library that hangs may call back long after its stream was abandoned: keep the callback by shared_ptr
/// until the library is certainly closed. Once abandoned, it outputs zeros and does not call the processor.
class CardCallback {
 public:
  /// [control] `processor` is prepared for `granted.format` and outlives `abandon`. `request` has the channel
  /// maps.
  CardCallback(GuardedBlocks& processor, const StreamRequest& request, const StreamGranted& granted);

  /// [control & not playing] Blocks reach the processor from now on.
  void play() noexcept;
  /// [control] The next blocks are the last, from Guarded::finish. Returns when every output was at zero;
  /// false when that takes half a second and four blocks longer than the guards need, and when no block comes
  /// for 100 ms and four blocks, or, `lost`, for 20 ms and four blocks: the device went away, and perhaps its
  /// outputs with it.
  bool finish(bool lost = false);
  /// [control] When it returns no block is in the processor, and none ever will be. Zeros go out.
  void abandon() noexcept;
  /// [control] Abandoned: returns when so many frames of zeros went out, or none came for half a second. A
  /// driver that plays its buffer on while it is being closed then plays zeros.
  void fill_with_zeros(std::int64_t frames) const;

  /// [realtime] One block. `in` and `out`: planes of the device, at least as many as the channel maps name;
  /// `in` may be nullptr, as may any plane: silence. `device_outputs`: how many planes to fill.
  void block(const float* const* in, float* const* out, int device_outputs, int frames) noexcept;

  /// [realtime] Between two blocks: every output of the device was brought to zero meanwhile. The guards come
  /// to zero unheard, and start softly.
  void restart_from_zero() noexcept;

  enum class GapLength { Unknown, Counted };  ///< counted: `lost` says it
  /// [realtime, any thread] A gap that the library reported.
  void gap(Gap gap, GapLength length = GapLength::Unknown) noexcept;
  /// [realtime, any thread] The flags of a library. With JACK they do not report where: both are always
  /// there.
  void gaps(bool jack, bool input, bool output) noexcept {
    if (jack && (input || output)) gap(Gap::Server);
    if (input && !jack) gap(Gap::Input);
    if (output && !jack) gap(Gap::Output);
  }
  /// [realtime] Frames that it reported lost.
  void lost(std::int64_t frames) noexcept;
  /// [any] Suspended: frames do not run at their rate, because the server freewheels or changed it. One block
  /// comes from Guarded::finish, then zeros go out and the processor is left alone; afterwards the guards
  /// start softly. Without this call, the same happens while frames run ahead of time (FrameWatch::ahead).
  void suspend(bool on) noexcept { suspended_.store(on); }

  /// [any]
  Health health() const noexcept { return meter_.read(); }
  /// [any] Blocks should flow, and none came for half a second and four blocks, or for `silence` if that is
  /// longer. When they come again, the outputs come to zero first and the guards start softly.
  bool stalled(std::chrono::milliseconds silence = {}) const noexcept;
  bool playing() const noexcept { return stage_.load() == Stage::Playing; }

 private:
  enum class Stage {
    Silent,  ///< zeros; the processor is left alone
    Playing,
    Finishing,  ///< the outputs come to zero
  };
  using Clock = std::chrono::steady_clock;

  void skip(Clock::time_point now) noexcept;
  bool process(const float* const* in, float* const* out, int offset, int frames, Stage stage) noexcept;
  void convert_input(const float* const* in, int offset, int frames) noexcept;
  void watch(int frames, Clock::time_point now) noexcept;
  void watch_buffer(Clock::time_point now) noexcept;

  GuardedBlocks& processor_;
  const StreamFormat format_;
  const std::chrono::nanoseconds patience_, lost_patience_, stopped_patience_;
  const std::chrono::nanoseconds buffer_;  ///< how long the driver's lasts; 0: unknown
  std::vector<int> in_map_, out_map_;
  ChannelBuffers in_, out_;
  std::atomic<Stage> stage_{Stage::Silent};
  std::atomic<bool> busy_{false}, suspended_{false};
  std::atomic<Clock::time_point> last_block_;  ///< when `play` began, until the first
  std::atomic<Clock::time_point> last_gap_;
  std::atomic<std::int64_t> zeros_{0};       ///< frames since `abandon`
  std::atomic<std::int64_t> gap_frames_{0};  ///< lost since the last block
  Clock::time_point first_block_;
  std::int64_t frames_ = 0;  ///< since `play`, with those that the library reported lost
  FrameWatch clock_;
  bool first_ = true;
  bool resumes_ = false;  ///< after a stall the outputs are not at zero yet
  bool paused_ = false;   ///< suspended, with the outputs at zero
  HealthMeter meter_;
};

/// [control] A stream on a sound library: its state, and the order in which callback and library start and
/// stop. `Line` is all that the library touches, with the callback as `card`.
template <class Line>
class CardStream : public Stream {
 public:
  /// `processor` is prepared for `granted.format`; `request` has the channel maps.
  CardStream(std::shared_ptr<Line> line, StreamGranted granted, const StreamRequest& request,
             GuardedBlocks& processor)
      : line_(std::move(line)), granted_(std::move(granted)) {
    line_->card = std::make_unique<CardCallback>(processor, request, granted_);
  }

  const StreamGranted& granted() const final { return granted_; }
  Status start(const std::function<void()>& ready) final {
    if (running_) return {};
    if (lost())
      return fail(Errc::Device, "", "'" + granted_.device + "' was disconnected",
                  granted_.comes_back ? "open it again" : "restart the program");
    if (auto status = start_library(); !status) return status;
    ready();
    line_->card->play();
    running_ = true;
    return {};
  }
  Status stop() final {
    const bool is_lost = lost();
    const bool at_zero = running_ && line_->card->finish(is_lost);
    if (!std::exchange(running_, false)) return {};
    line_->card->abandon();
    if (at_zero && !is_lost) line_->card->fill_with_zeros(buffered_frames());
    return stop_library(at_zero && !is_lost);
  }
  StreamState state() const final {
    if (lost()) return StreamState::Lost;
    if (!running_) return StreamState::Stopped;
    return line_->card->stalled() ? StreamState::Stalled : StreamState::Running;
  }
  Health health() const final { return line_->card->health(); }

 protected:
  bool running() const { return running_; }

  std::shared_ptr<Line> line_;

 private:
  /// [control] The device or its server went away.
  virtual bool lost() const = 0;
  /// [control] Frames that the driver may play again and again while the library closes it.
  virtual std::int64_t buffered_frames() const { return 0; }
  /// [control] Blocks begin to flow. Errors: Device.
  virtual Status start_library() = 0;
  /// [control] No block comes any more. `finished`: the last block was played. Errors: Device.
  virtual Status stop_library(bool finished) = 0;

  StreamGranted granted_;
  bool running_ = false;
};

}  // namespace tactus
