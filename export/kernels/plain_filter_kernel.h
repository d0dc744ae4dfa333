#pragma once

// Thread: [realtime].

#include "engine/dsp/filters/filter_kernel.h"

// Takes the place of the filter that runs on a grid of eight frames: the same names, half the work. Never
// compiled beside that one, but exported instead of it.

/// y[n] = b0 x[n] + b1 x[n-1] + b2 x[n-2] + a1 y[n-1] + a2 y[n-2], straight from the definition; of order 1
/// without b2 and a2.
typedef struct tactus_filter {
  tactus_filter_design design;
  tactus_real x[2], y[2];  ///< newest first
} tactus_filter;

static inline void tactus_filter_set(tactus_filter* s, tactus_filter_design design) { s->design = design; }

static inline tactus_real tactus_filter_step(tactus_filter* s, int order, tactus_real in, int position) {
  const tactus_real *a = s->design.a, *b = s->design.b;
  // Not fused, so that equal inputs cancel exactly.
  tactus_real out = b[0] * in;
  if (order == 2) out = out + b[2] * s->x[1];
  out = out + b[1] * s->x[0];
  if (order == 2) out = tactus_fma(a[1], s->y[1], out);
  out = tactus_fma(a[0], s->y[0], out);
  (void)position;
  if (order == 2) {
    s->x[1] = s->x[0];
    s->y[1] = s->y[0];
  }
  s->x[0] = in;
  s->y[0] = out;
  return out;
}
