#pragma once

#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "backends/backend.h"
#include "backends/card_callback.h"
#include "backends/paced/frame_timer.h"
#include "backends/paced/paced_loop.h"

namespace tactus {

/// How a paced loop runs.
struct PacedSettings {
  SystemTimer::Wait wait = SystemTimer::Wait::Timer;
  std::optional<int> core;  ///< that the loop alone runs on
  int priority = 80;        ///< of SCHED_FIFO, where it is permitted

  bool operator==(const PacedSettings&) const = default;
};

/// [any] The rates of paced loops, from 1 kHz to 20 kHz.
std::vector<Hertz> paced_rates();

/// [control] All that the thread of a paced loop touches.
struct PacedLine {
  PacedLine(std::unique_ptr<FrameDevice> frames, int rate_hz, const PacedSettings& with)
      : device(std::move(frames)), loop(*device, rate_hz), settings(with) {}

  std::unique_ptr<FrameDevice> device;
  PacedLoop loop;
  const PacedSettings settings;
  std::unique_ptr<CardCallback> card;
  std::atomic<bool> stops{false};
};

/// A stream of one frame a block: a thread of its own reads, processes and writes a frame in each period,
/// with real-time priority where that is permitted. Frames that were skipped are gaps of its Health.
class PacedStream final : public CardStream<PacedLine> {
 public:
  /// [control] The device has the channels of `granted`, in that order; its block is one frame. Errors: those
  /// of `processor.prepare`; OutOfRange for the core.
  static Result<std::unique_ptr<Stream>> open(std::unique_ptr<FrameDevice> device, StreamGranted granted,
                                              const PacedSettings& settings, GuardedBlocks& processor);
  ~PacedStream() override { static_cast<void>(stop()); }

  /// [control] After 2 s how late frames were; again when one was much later, or frames were skipped.
  std::string take_note() override;
  /// [any]
  const PacedLoop& loop() const noexcept { return line_->loop; }

 private:
  using CardStream::CardStream;

  bool lost() const override { return line_->loop.lost() || line_->device->lost(); }
  Status start_library() override;
  Status stop_library(bool finished) override;

  std::thread thread_;
  std::int64_t noted_us_ = 0, noted_skipped_ = 0;
};

}  // namespace tactus
