#pragma once

// Thread: [realtime].

#include "engine/dsp/envelopes/rise_kernel.h"

/// The input at the last trigger; 0 before the first.
typedef struct tactus_sample_hold {
  tactus_rise rise;
  tactus_real held;
} tactus_sample_hold;

static inline tactus_real tactus_sample_hold_step(tactus_sample_hold* s, tactus_real in,
                                                  tactus_real trigger) {
  if (tactus_rise_step(&s->rise, trigger)) s->held = in;
  return s->held;
}
