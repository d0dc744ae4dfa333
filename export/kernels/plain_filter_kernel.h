#pragma once

// Thread: [realtime].

#include "engine/dsp/filters/filter_kernel.h"
#include "export/kernels/recurrence_kernel.h"

// Takes the place of the filter that runs on a grid of eight frames, for kernels that contain one: the same
// names, half the work. Never compiled beside that one, but exported instead of it.

/// A filter of order 1 or 2, frame by frame.
typedef struct tactus_filter {
  tactus_filter_design design;
  tactus_real x[2], y[2];  ///< newest first
} tactus_filter;

static inline void tactus_filter_set(tactus_filter* s, tactus_filter_design design) { s->design = design; }

static inline tactus_real tactus_filter_step(tactus_filter* s, int order, tactus_real in, int position) {
  const tactus_real *a = s->design.a, *b = s->design.b;
  (void)position;
  if (order == 2)
    return tactus_recurrence_2(b[0], b[1], b[2], a[0], a[1], in, &s->x[0], &s->x[1], &s->y[0], &s->y[1]);
  return tactus_recurrence_1(b[0], b[1], a[0], in, &s->x[0], &s->y[0]);
}
