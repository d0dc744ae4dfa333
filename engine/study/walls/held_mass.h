#pragma once
// Thread: [any]

#include <algorithm>
#include <cmath>

#include "engine/core/units.h"

namespace tactus {

/// A mass on a damper under a force that is held:  m x'' + b x' = F.  After t seconds
///     x+ = x + reach v + rise F,   v+ = keep v + gain F
/// with y = b t / m, keep = e^-y, reach = t phi1(y), gain = t/m phi1(y), rise = t^2/m phi2(y),
///     phi1(y) = (1 - e^-y) / y,   phi2(y) = (y - 1 + e^-y) / y^2:
/// the exact solution, however long t is. Also right without damping (y = 0) and for t = 0.
/// Source: Franklin, Powell, Workman, "Digital control of dynamic systems", 3rd ed., section 4.3.
struct HeldMass {
  double keep = 1, reach = 0, gain = 0, rise = 0;

  /// m [kg] > 0, b [N s/m] >= 0, t [s] >= 0
  static HeldMass over(double mass, double damping, double seconds) {
    const double y = damping * seconds / mass;
    return {std::exp(-y), seconds * phi1(y), seconds / mass * phi1(y), seconds * seconds / mass * phi2(y)};
  }

  static double phi1(double y) { return y < 1e-12 ? 1.0 : -std::expm1(-y) / y; }
  static double phi2(double y) {
    if (y > 0.5) return (1 - phi1(y)) / y;
    // 1/2! - y/3! + y^2/4! - ..., where the difference above would lose digits.
    double sum = 0, term = 0.5;
    for (int n = 3; n < 18; ++n) {
      sum += term;
      term *= -y / n;
    }
    return sum;
  }
};

/// A delay in whole frames and a fraction from 0 to below 1. Within a billionth of a frame it is whole.
struct SplitDelay {
  SplitDelay(Seconds delay, Hertz rate) {
    const double frames = frames_in(delay, rate);
    whole = static_cast<int>(std::floor(frames + 1e-9));
    fraction = std::max(0.0, frames - whole);
    if (fraction < 1e-9) fraction = 0;
  }

  int whole;
  double fraction;
};

}  // namespace tactus
