#pragma once

// Thread: [realtime].

#include "engine/dsp/envelopes/rise_kernel.h"

/// 1 from a trigger at `set` until one at `reset`, which wins in the same frame.
typedef struct tactus_latch {
  tactus_rise set, reset;
  int on;
} tactus_latch;

static inline tactus_real tactus_latch_step(tactus_latch* s, tactus_real set, tactus_real reset) {
  if (tactus_rise_step(&s->set, set)) s->on = 1;
  if (tactus_rise_step(&s->reset, reset)) s->on = 0;
  return s->on ? 1.0 : 0.0;
}
