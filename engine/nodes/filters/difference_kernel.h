#pragma once

// Thread: [realtime].

#include "engine/dsp/kernel.h"

/// Backward difference, per second; 0 comes before the first frame.
typedef struct tactus_difference {
  tactus_real before;
} tactus_difference;

static inline tactus_real tactus_difference_step(tactus_difference* s, tactus_real in, tactus_real rate) {
  const tactus_real out = (in - s->before) * rate;
  s->before = in;
  return out;
}
