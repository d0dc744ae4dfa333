#pragma once

// Thread: [realtime].

#include "engine/dsp/envelopes/envelope_kernel.h"

/// Goes through a list of values, one at each trigger. `place` is one above the place in the list, so that
/// all is 0 at the start.
typedef struct tactus_sequence {
  tactus_rise trigger, reset;
  int place;
} tactus_sequence;

/// 1 in the frame of a trigger whose value is not 0. The value is then `values[tactus_sequence_index(s)]`. A
/// reset in the frame of a trigger comes first.
static inline int tactus_sequence_step(tactus_sequence* s, tactus_real trigger, tactus_real reset,
                                       const tactus_real* values, int count) {
  if (tactus_rise_step(&s->reset, reset)) s->place = 0;
  if (!tactus_rise_step(&s->trigger, trigger)) return 0;
  s->place = s->place % count + 1;
  return values[s->place - 1] != 0;
}
static inline int tactus_sequence_index(const tactus_sequence* s) { return s->place > 0 ? s->place - 1 : 0; }
