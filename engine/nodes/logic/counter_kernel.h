#pragma once

// Thread: [realtime].

#include "engine/dsp/envelopes/rise_kernel.h"

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
