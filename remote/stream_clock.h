#pragma once
// Thread: [control]

#include <chrono>
#include <cstdint>

#include "engine/core/units.h"

namespace tactus {

/// [any] By the system clock, since 1970.
inline double system_seconds() {
  return std::chrono::duration<double>{std::chrono::system_clock::now().time_since_epoch()}.count();
}

/// Which frame of a stream is processed at which time of the system clock. The frame counter is read now and
/// then; it advances by whole blocks, so each reading is late by up to a block, and their mean by half of
/// one, always the same. A delay-locked loop of second order follows the readings:
///   e = frame - predicted;  predicted += rate t + 2 w e + drift;  drift += w^2 e
/// Its first readings are averaged. A reading that is off by more than 100 ms (the clock was set, the stream
/// stood still) starts it again.
/// Source: F. Adriaensen, "Using a DLL to filter time", 2005.
class StreamClock {
 public:
  explicit StreamClock(Hertz sample_rate) : rate_(sample_rate.value) {}

  /// Frames are counted from 0 again.
  void restart() { readings_ = 0; }
  /// A reading at `time_s` of the system clock.
  void update(double time_s, std::int64_t frame);
  /// There were readings for long enough.
  bool known() const { return readings_ >= kFirst; }
  /// Not rounded.
  double frame_at(double time_s) const { return base_ + rate_ * (time_s - time_s_); }
  double time_of(double frame) const { return time_s_ + (frame - base_) / rate_; }

 private:
  static constexpr int kFirst = 20;

  double rate_;          ///< frames a second, nominal and then as observed
  double base_ = 0.0;    ///< predicted frame at `time_s_`
  double time_s_ = 0.0;  ///< of the last reading
  double nominal_ = rate_;
  int readings_ = 0;
};

}  // namespace tactus
