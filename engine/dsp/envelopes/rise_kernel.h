#pragma once

// Thread: [realtime].

#include "engine/dsp/kernel.h"

/// Fires in the one frame in which a trigger signal rises through 0.5. Before the first frame the
/// signal counts as low, so that a signal which starts high fires at once.
typedef struct tactus_rise {
  int high;
} tactus_rise;

static inline int tactus_rise_step(tactus_rise* s, tactus_real trigger) {
  const int was_high = s->high;
  s->high = trigger >= 0.5;
  return s->high > was_high;
}

/// Whether none of `count` frames changes anything; then they may be left out.
static inline int tactus_rise_indifferent(const tactus_rise* s, const tactus_real* trigger, int count) {
  int above = 0;
  if (s->high) return 0;
  for (int n = 0; n < count; ++n) above += trigger[n] >= 0.5;
  return above == 0;
}
