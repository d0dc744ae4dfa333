#pragma once

// Thread: [realtime].

#include "engine/dsp/envelopes/envelope_kernel.h"

/// Counts triggers modulo floor(count); count < 1: without end.
typedef struct tactus_counter {
  tactus_rise trigger, reset;
  tactus_real counted;  ///< whole: exact up to 2^53
} tactus_counter;

static inline tactus_real tactus_counter_step(tactus_counter* s, tactus_real trigger, tactus_real reset,
                                              tactus_real count) {
  if (tactus_rise_step(&s->trigger, trigger)) {
    ++s->counted;
    if (count >= 1 && s->counted >= floor(count)) s->counted = 0;
  }
  if (tactus_rise_step(&s->reset, reset)) s->counted = 0;
  return s->counted;
}

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

/// Changes between 0 and 1 at each trigger; a reset wins in the same frame.
typedef struct tactus_toggle {
  tactus_rise trigger, reset;
  int on;
} tactus_toggle;

static inline tactus_real tactus_toggle_step(tactus_toggle* s, tactus_real trigger, tactus_real reset) {
  if (tactus_rise_step(&s->trigger, trigger)) s->on = !s->on;
  if (tactus_rise_step(&s->reset, reset)) s->on = 0;
  return s->on ? 1.0 : 0.0;
}
