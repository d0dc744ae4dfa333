#pragma once

#include <cmath>

namespace tactus {

/// The multiple of `step` nearest to `value` (halves go to the even multiple). step <= 0: no rounding.
inline double quantise_nearest(double value, double step) {
  const double steps = step > 0 ? std::rint(value / step) : HUGE_VAL;
  // Where value / step overflows, the step is below the resolution of the value.
  return std::isfinite(steps) ? steps * step : value;
}

/// The largest multiple of `step` that is not above `value`. step <= 0: no rounding.
inline double quantise_floor(double value, double step) {
  const double steps = step > 0 ? std::floor(value / step) : HUGE_VAL;
  return std::isfinite(steps) ? steps * step : value;
}

}  // namespace tactus
