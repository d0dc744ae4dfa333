#pragma once

// Thread: [realtime].

#include "engine/dsp/envelopes/envelope_kernel.h"

/// A run through a curve, at the speed and the level that were read when it started.
typedef struct tactus_curve_run {
  tactus_rise rise;
  int started;
  long long frames;  ///< since the start
  tactus_real speed, level;
} tactus_curve_run;

/// The place on the curve, in frames of the curve at speed 1. `waits`: at the first point until a trigger.
static inline tactus_real tactus_curve_run_step(tactus_curve_run* s, tactus_real trigger, tactus_real speed,
                                                tactus_real level, int waits) {
  const int starts = tactus_rise_step(&s->rise, trigger) || (!waits && !s->started);
  if (starts || !s->started) {
    s->speed = tactus_clamp(speed, 0.0, 1e6);
    s->level = level;
    s->frames = 0;
  } else {
    ++s->frames;
  }
  s->started = s->started || starts;
  return s->speed * (tactus_real)s->frames;
}
