#pragma once

#include "engine/dsp/kernel.h"

// Thread: [realtime].

// Filters frame by frame, straight from their equations. Products are not fused with the first of them, so
// that equal inputs cancel exactly. State is passed number by number: one that is not used takes no memory,
// and lanes that do the same have theirs side by side, as vector instructions want it.

/// y[n] = b0 x[n] + a1 y[n-1]. `y1`: the last output.
static inline tactus_real tactus_recurrence_pole(tactus_real b0, tactus_real a1, tactus_real in,
                                                 tactus_real* y1) {
  *y1 = tactus_fma(a1, *y1, b0 * in);
  return *y1;
}

/// y[n] = b0 x[n] + b1 x[n-1] + a1 y[n-1]. `x1`, `y1`: the last input and output.
static inline tactus_real tactus_recurrence_1(tactus_real b0, tactus_real b1, tactus_real a1, tactus_real in,
                                              tactus_real* x1, tactus_real* y1) {
  *y1 = tactus_fma(a1, *y1, b0 * in + b1 * *x1);
  *x1 = in;
  return *y1;
}

/// y[n] = b0 x[n] + b1 x[n-1] + b2 x[n-2] + a1 y[n-1] + a2 y[n-2]. `x2`, `y2`: those before the last ones.
static inline tactus_real tactus_recurrence_2(tactus_real b0, tactus_real b1, tactus_real b2, tactus_real a1,
                                              tactus_real a2, tactus_real in, tactus_real* x1,
                                              tactus_real* x2, tactus_real* y1, tactus_real* y2) {
  const tactus_real out = tactus_fma(a1, *y1, tactus_fma(a2, *y2, b0 * in + b2 * *x2 + b1 * *x1));
  *x2 = *x1;
  *x1 = in;
  *y2 = *y1;
  *y1 = out;
  return out;
}
