#pragma once

#include <limits>
#include <optional>

#include "engine/core/error.h"
#include "engine/core/units.h"

namespace tactus {

/// Thermal limits of a coil: a network of two thermal masses, the coil and the body (magnet, can) around
/// it, in which a steady power brings the coil to its limit in the end, the share `coil_share` of the way
/// from the body to the coil and the rest from the room to the body. Only power counts, V²/R, never a signed
/// force.
struct HeatLimits {
  double watts_at_full_scale = 0.0;  ///< V²/R of a steady sample of 1; > 0
  double watts_for_ever = 0.0;       ///< the steady power that leads to the limit; > 0
  Seconds coil_time{1.0};            ///< time constant of the coil towards the body; >= 10 ms
  Seconds body_time{300.0};          ///< time constant of the body towards the room; >= 10 ms
  double coil_share = 0.5;           ///< (0, 1)
  double rise_kelvin = 100.0;        ///< the limit: how much warmer than the room the coil may become; > 0
};

/// Excursion limit of a mass on a spring. A voltage y pushes it like a force that would hold it at
/// `metres_at_full_scale` * y.
struct ExcursionLimits {
  double metres = 0.0;                ///< the limit; > 0
  double metres_at_full_scale = 0.0;  ///< Bl V / (R_e k) with V the volts of a sample of 1; > 0
  Hertz resonance{40.0};              ///< sqrt(k / m) / 2π; > 0
  double q = 1.0;                     ///< sqrt(k m) / (c + Bl²/R_e); > 0
};

/// How long DC may last: the mean of the drive over half a second may lie beyond `level` for
/// `time`.
struct DcLimits {
  double level = 1.0;  ///< what may last for ever; > 0, and 1 is no limit
  Seconds time{0.0};   ///< [0 s, an hour]
};

/// Limits of an actuator, at the converter: full scale = 1.
struct DriveLimits {
  double ceiling = 1.0;                                              ///< |y| <= ceiling; (0, 1]
  double slew_per_second = std::numeric_limits<double>::infinity();  ///< |dy/dt| in full scales a second; > 0
  Seconds soft_start{0.0};  ///< gain rises 0 to 1 in this; [0 s, 60 s]
  Seconds fade_out{0.005};  ///< gain falls to 0 in this; [0 s, 1 s]
  std::optional<HeatLimits> heat = {};
  std::optional<ExcursionLimits> excursion = {};
  DcLimits dc = {};
};

/// [any] How long fading out takes at most: the ramp, and what the slew limit needs from the ceiling to zero.
inline Seconds closing_time(const DriveLimits& limits) noexcept {
  return limits.fade_out + Seconds{limits.ceiling / limits.slew_per_second};
}

/// [any] For a drive whose actuator is unknown. Why these: docs/decisions.md.
DriveLimits conservative_limits();

/// [control] OutOfRange if a limit makes no sense, or cannot be kept at this rate: no coil may go
/// through more than an eighth of its heat in 64 frames at the ceiling, or on the way from there to 0.
[[nodiscard]] Status check(const DriveLimits& limits, Hertz sample_rate = 48_kHz);

}  // namespace tactus
