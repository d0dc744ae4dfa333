#pragma once

#include <chrono>
#include <optional>

#include "engine/core/error.h"

namespace tactus {

/// The clock of a paced loop.
class FrameTimer {
 public:
  using Time = std::chrono::nanoseconds;  ///< since any instant

  virtual ~FrameTimer() = default;
  /// [realtime]
  virtual Time now() noexcept = 0;
  /// [realtime] Returns at `time` or later; at once where that is past.
  virtual void wait_until(Time time) noexcept = 0;
};

/// [any] The clock of the system.
class SystemTimer final : public FrameTimer {
 public:
  enum class Wait {
    Timer,  ///< the thread sleeps until an absolute time: other threads run meanwhile
    Busy,   ///< it reads the clock again and again: for a core of its own
  };
  explicit SystemTimer(Wait wait) : wait_(wait) {}

  Time now() noexcept override;
  void wait_until(Time time) noexcept override;

 private:
  Wait wait_;
};

/// [control] Whether a thread may run on this core alone. Errors: OutOfRange.
Status check_core(int core);
/// [any] The calling thread runs on this core alone, also on one that is isolated. Errors: OutOfRange.
Status stay_on_core(int core);

}  // namespace tactus
