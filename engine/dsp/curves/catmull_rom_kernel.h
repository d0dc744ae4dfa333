#pragma once

// Thread: [realtime].

#include "engine/dsp/kernel.h"

/// Cubic through `b` (at = 0) and `c` (at = 1) with the slopes (c - a) / 2 and (d - b) / 2;
/// continuous in value and slope from one interval to the next, and exact for parabolas. Catmull & Rom, "A
/// class of local interpolating splines", 1974.
static inline tactus_real tactus_catmull_rom(tactus_real a, tactus_real b, tactus_real c, tactus_real d,
                                             tactus_real at) {
  const tactus_real slope_b = 0.5 * (c - a);
  const tactus_real slope_c = 0.5 * (d - b);
  const tactus_real cubic = slope_b + slope_c - 2.0 * (c - b);
  const tactus_real square = (c - b) - slope_b - cubic;
  return ((cubic * at + square) * at + slope_b) * at + b;
}
