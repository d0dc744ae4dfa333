#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <vector>

#include "backends/paced/frame_schedule.h"
#include "backends/paced/frame_timer.h"
#include "backends/paced/lateness.h"
#include "engine/core/index.h"
#include "engine/core/realtime.h"

namespace tactus {

/// What converts single frames. An output keeps its value until it is written again. Values are shares of
/// full scale.
class FrameDevice {
 public:
  virtual ~FrameDevice() = default;
  /// [any]
  virtual int in_channels() const = 0;
  virtual int out_channels() const = 0;
  /// [realtime] All inputs as they are now, at the frame of this number; numbers may be left out. False: the
  /// device is gone.
  virtual bool read(std::int64_t frame, float* in) noexcept = 0;
  /// [realtime] All outputs, each finite. False: the device is gone.
  virtual bool write(std::int64_t frame, const float* out) noexcept = 0;
  /// [realtime] No output keeps a value.
  virtual void to_zero() noexcept = 0;
  /// [control] Frames follow from now on, or no more.
  virtual void expect_frames(bool) noexcept {}
  /// [control] It cannot be used any more.
  virtual bool lost() const { return false; }
};

/// How a frame comes about.
struct PacedFrame {
  std::int64_t skipped = 0;  ///< frames that were left out before it
  bool from_zero = false;    ///< before it every output was brought to zero
};

/// A loop that reads, processes and writes one frame in each period. Every output is brought to zero at the
/// end, when the device fails, and when a frame is late by `kLongest` or more, before it is processed.
class PacedLoop {
 public:
  static constexpr std::chrono::milliseconds kLongest{500};  ///< as of the dead man's switch

  /// [control] `device` outlives this. `rate_hz` > 0.
  PacedLoop(FrameDevice& device, int rate_hz)
      : device_(device),
        rate_(rate_hz),
        in_(index(device.in_channels())),
        out_(index(device.out_channels())) {}

  /// [realtime] Until `stops`, or the device is gone. process(in, out, PacedFrame): one frame.
  template <class Process>
  void run(FrameTimer& timer, const std::atomic<bool>& stops, Process process) noexcept {
    const NoDenormals no_denormals;
    FrameSchedule schedule{rate_, timer.now()};
    while (!stops && !lost_) {
      timer.wait_until(schedule.next_due());
      const auto woken = timer.now();
      const auto turn = schedule.wake(woken);
      lateness_.add(turn.late);
      if (turn.skipped > 0) {
        add(overruns_, 1);
        add(skipped_, turn.skipped);
      }
      const bool from_zero = turn.late >= kLongest;
      if (from_zero) device_.to_zero();
      bool works = device_.read(turn.frame, in_.data());
      if (works) process(in_.data(), out_.data(), PacedFrame{turn.skipped, from_zero});
      works = works && device_.write(turn.frame, out_.data());
      if (!works) lost_ = true;
      add(frames_, 1);
      answer_.add(timer.now() - woken);
    }
    device_.to_zero();
  }

  /// [any] How late frames began.
  const LatenessHistogram& lateness() const noexcept { return lateness_; }
  /// [any] From the beginning of a frame until its outputs were written.
  const LatenessHistogram& answer() const noexcept { return answer_; }
  /// [any] Frames processed; how often frames were skipped, and how many.
  std::int64_t frames() const noexcept { return frames_; }
  std::int64_t overruns() const noexcept { return overruns_; }
  std::int64_t skipped() const noexcept { return skipped_; }
  /// [any] The device is gone.
  bool lost() const noexcept { return lost_; }
  int rate_hz() const noexcept { return rate_; }

 private:
  static void add(std::atomic<std::int64_t>& counter, std::int64_t more) noexcept {
    counter.store(counter.load(std::memory_order_relaxed) + more, std::memory_order_relaxed);
  }

  FrameDevice& device_;
  const int rate_;
  std::vector<float> in_, out_;
  LatenessHistogram lateness_, answer_;
  std::atomic<std::int64_t> frames_{0}, overruns_{0}, skipped_{0};
  std::atomic<bool> lost_{false};
};

}  // namespace tactus
