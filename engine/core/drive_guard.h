#pragma once

#include <cstdint>
#include <limits>

#include "engine/core/error.h"
#include "engine/core/realtime.h"
#include "engine/core/units.h"

namespace tactus {

/// What an actuator stands, at the converter: full scale = 1.
struct DriveLimits {
  double ceiling = 1.0;                                              ///< |y| <= ceiling; (0, 1]
  double slew_per_second = std::numeric_limits<double>::infinity();  ///< |dy/dt| in full scales a second; > 0
  Seconds soft_start{0.0};  ///< gain rises 0 to 1 in this; [0 s, 60 s]
  Seconds fade_out{0.005};  ///< gain falls to 0 in this; [0 s, 1 s]
};

/// [control] OutOfRange, in words, if a limit makes no sense.
[[nodiscard]] Status check(const DriveLimits& limits);

/// How many frames each stage had to change.
struct GuardCounts {
  std::int64_t nonfinite = 0;
  std::int64_t ceiling = 0;
  std::int64_t slew = 0;

  bool operator==(const GuardCounts&) const = default;
};

/// A gain that moves on a straight line between two absolute frames, so that no block size enters:
///   g(n) = from + (to - from) (n - start) / length,   g = to from n = start + length on.
class GainRamp {
 public:
  explicit GainRamp(double gain) : from_(gain), to_(gain) {}

  /// [realtime] From the gain at `frame` to `target` in `length` frames.
  void begin(std::int64_t frame, std::int64_t length, double target) noexcept {
    from_ = at(frame);
    to_ = target;
    start_ = frame;
    length_ = length;
  }
  double at(std::int64_t frame) const noexcept {
    const auto elapsed = frame - start_;
    if (elapsed < 0) return from_;
    if (elapsed >= length_) return to_;
    return from_ + (to_ - from_) * (static_cast<double>(elapsed) / static_cast<double>(length_));
  }
  bool at_rest(std::int64_t frame) const noexcept { return frame - start_ >= length_; }
  double target() const noexcept { return to_; }

 private:
  double from_, to_;
  std::int64_t start_ = 0, length_ = 0;
};

/// The fixed last stage of one output channel. Stages, each over the whole piece before the next:
///   finite    a NaN or infinity becomes 0
///   gain      soft start, arm, mute
///   ceiling   y = clamp(x, -ceiling, ceiling)
///   slew      y[n] = clamp(x[n], y[n-1] - s, y[n-1] + s),  s = slew_per_second / sample_rate,  y[-1] = 0
/// Slew stays below the ceiling since it lies between two values that do. Within its limits, and at gain 1,
/// the output is the input bit for bit; there is no delay. How frames are cut into pieces does not matter.
class DriveGuard {
 public:
  enum class Kind {
    Drive,  ///< moves something: all stages
    Audio,  ///< is only heard: no slew
  };

  /// [control] `limits` must have passed `check`.
  DriveGuard(Kind kind, const DriveLimits& limits, Hertz sample_rate);

  /// [realtime] Lets sound through from `frame` on (soft start), or fades it out. Asking twice changes
  /// nothing.
  void set_open(bool open, std::int64_t frame) noexcept;
  bool is_open() const noexcept { return gain_.target() > 0.0; }

  /// [realtime] In place. `first_frame`: number of samples[0] since the start.
  void process(double* samples, int frames, std::int64_t first_frame) noexcept TACTUS_NONBLOCKING;

  Kind kind() const noexcept { return kind_; }
  const GuardCounts& counts() const noexcept { return counts_; }

 private:
  void make_finite(double* samples, int frames) noexcept;
  void apply_gain(double* samples, int frames, std::int64_t first_frame) noexcept;
  void apply_ceiling(double* samples, int frames) noexcept;
  void apply_slew(double* samples, int frames) noexcept;

  Kind kind_;
  double ceiling_;
  double largest_step_;
  std::int64_t rise_frames_, fall_frames_;
  GainRamp gain_{0.0};
  double last_ = 0.0;
  GuardCounts counts_;
};

}  // namespace tactus
