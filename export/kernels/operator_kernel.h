#pragma once

// Thread: [any].

#include "engine/dsp/kernel.h"

// Operators of expressions that are more than one of C.

/// 0 where b is 0: a control at its end must not make a loop fault.
static inline tactus_real tactus_quotient(tactus_real a, tactus_real b) { return b == 0 ? 0 : a / b; }
/// b where a is not a number, unlike tactus_min and tactus_max.
static inline tactus_real tactus_smaller(tactus_real a, tactus_real b) { return a < b ? a : b; }
static inline tactus_real tactus_larger(tactus_real a, tactus_real b) { return a > b ? a : b; }
static inline tactus_real tactus_sign(tactus_real a) {
  return (a > 0 ? (tactus_real)1.0 : (tactus_real)0.0) - (a < 0 ? (tactus_real)1.0 : (tactus_real)0.0);
}
/// Halves away from zero.
static inline tactus_real tactus_round(tactus_real a) {
  // The largest double below 1/2: 1/2 itself would round 0.49999999999999994 up.
  const tactus_real size = a < 0 ? -a : a, up = floor(size + 0.49999999999999994);
  return a < 0 ? -up : up;
}
/// As tactus_mod, to within rounding.
static inline tactus_real tactus_modulo(tactus_real a, tactus_real b) { return a - b * floor(a / b); }
/// What is not finite becomes 0.
static inline tactus_real tactus_finite(tactus_real a) { return tactus_is_finite(a) ? a : 0; }
/// A sample from outside: numbers too small to be normal are 0, as for the engine.
static inline tactus_real tactus_sample_in(tactus_real a) {
  const tactus_real size = fabs(a);
  return (size >= 2.2250738585072014e-308) & !(size >= HUGE_VAL) ? a : 0;
}
/// Whether a parameter is another one than before.
static inline int tactus_changed(tactus_real* before, tactus_real now) {
  const int changed = !(now == *before);
  *before = now;
  return changed;
}
