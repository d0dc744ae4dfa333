#pragma once

// Thread: [realtime].

#include "engine/dsp/kernel.h"

/// Running phase in turns:  p[n+1] = frac(p[n] + f[n] / sample_rate),  0 <= p < 1.
/// Rounding adds at most 1.2e-16 turns a frame: below 1e-9 turns after an hour at 48 kHz if errors do not
/// line up, 2e-8 if they all do.
typedef struct tactus_phasor {
  tactus_real turns;
} tactus_phasor;

/// The phase of this frame; then moves on by `increment` turns of either sign.
static inline tactus_real tactus_phasor_step(tactus_phasor* s, tactus_real increment) {
  const tactus_real now = s->turns;
  s->turns += increment;
  s->turns -= floor(s->turns);
  // A tiny negative phase plus one rounds to one.
  if (s->turns >= 1) s->turns = 0;
  return now;
}
