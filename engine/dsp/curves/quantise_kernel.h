#pragma once

// Thread: [realtime].

#include "engine/dsp/kernel.h"

/// The multiple of `step` nearest to `value` (halves go to the even multiple). step <= 0: no
/// rounding. Where value / step overflows, the step is below the resolution of the value.
static inline tactus_real tactus_quantise_nearest(tactus_real value, tactus_real step) {
  const tactus_real steps = step > 0 ? rint(value / step) : HUGE_VAL;
  return tactus_is_finite(steps) ? steps * step : value;
}

/// The largest multiple of `step` that is not above `value`. step <= 0: no rounding.
static inline tactus_real tactus_quantise_floor(tactus_real value, tactus_real step) {
  const tactus_real steps = step > 0 ? floor(value / step) : HUGE_VAL;
  return tactus_is_finite(steps) ? steps * step : value;
}
