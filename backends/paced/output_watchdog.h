#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <vector>

#include "engine/core/error.h"

namespace tactus {

/// Finds that frames stay out. Thread: [any, one thread]
class FrameStall {
 public:
  using Time = std::chrono::nanoseconds;

  explicit FrameStall(Time patience) : patience_(patience) {}
  /// `frames`: how many there were until now. True, once in a stall: there was no further one for `patience`.
  bool observe(std::int64_t frames, Time now) noexcept {
    if (!observed_ || frames != frames_) {
      frames_ = frames;
      since_ = now;
      observed_ = true;
      reported_ = false;
    }
    if (reported_ || now - since_ < patience_) return false;
    return reported_ = true;
  }
  /// None is expected until the next one is observed.
  void pause() noexcept { observed_ = false; }

 private:
  Time patience_;
  std::int64_t frames_ = 0;
  Time since_{0};
  bool observed_ = false, reported_ = false;
};

/// A second process that brings the outputs of a device to zero when this one ends, in whatever way, and when
/// its loop made no frame for 500 ms: the outputs of a data acquisition card keep their last value, and a
/// program that was killed cannot change it any more. It ignores signals, and ends with this process.
class OutputWatchdog {
 public:
  static constexpr std::chrono::milliseconds kPatience{500};  ///< as of the dead man's switch

  /// [control] `to_zero(context)` runs in the other process, which is forked from this one: it may make
  /// system calls and nothing else. `files` are kept open there, and all others closed. Errors: Device.
  static Result<std::unique_ptr<OutputWatchdog>> start(void (*to_zero)(void*), void* context,
                                                       std::vector<int> files);
  OutputWatchdog(const OutputWatchdog&) = delete;
  OutputWatchdog& operator=(const OutputWatchdog&) = delete;
  /// [control] The outputs come to zero, and the process ends.
  ~OutputWatchdog();

  /// [realtime] A frame was made.
  void frame() noexcept {
    shared_->frames.store(shared_->frames.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
  }
  /// [control] Frames follow from now on, or no more.
  void expect_frames(bool on) noexcept { shared_->expected.store(on); }
  /// [control] False: somebody ended the process.
  bool alive() noexcept;

 private:
  struct Shared {
    std::atomic<std::int64_t> frames{0};
    std::atomic<bool> expected{false};
  };

  OutputWatchdog(Shared* shared, int socket, int process)
      : shared_(shared), socket_(socket), process_(process) {}
  [[noreturn]] static void guard(const Shared& shared, int socket, void (*to_zero)(void*),
                                 void* context) noexcept;

  Shared* shared_;  ///< memory of both processes
  int socket_;      ///< closed when this process ends
  int process_;     ///< 0: it has ended
};

}  // namespace tactus
