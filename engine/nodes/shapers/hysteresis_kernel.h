#pragma once

// Thread: [realtime].

#include "engine/dsp/kernel.h"

/// The play operator: a rod in a slot of the given width, pushed by the ends of the slot.
typedef struct tactus_hysteresis {
  tactus_real last;
} tactus_hysteresis;

static inline tactus_real tactus_hysteresis_step(tactus_hysteresis* s, tactus_real in, tactus_real width) {
  const tactus_real half = 0.5 * tactus_max(0.0, width);
  s->last = tactus_clamp(s->last, in - half, in + half);
  return s->last;
}
