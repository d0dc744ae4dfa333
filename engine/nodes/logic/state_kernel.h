#pragma once

// Thread: [realtime].

#include "engine/dsp/envelopes/envelope_kernel.h"

// Nodes that may close loops: what they give in a frame does not depend on their triggers in that frame.

/// A value that takes over its input in the frame after a trigger, so that the input may depend on it.
typedef struct tactus_state {
  tactus_rise rise;
  int taken;
  tactus_real value;
} tactus_state;

static inline tactus_real tactus_state_value(const tactus_state* s, tactus_real initial) {
  return s->taken ? s->value : initial;
}
static inline void tactus_state_take(tactus_state* s, tactus_real in, tactus_real trigger) {
  if (!tactus_rise_step(&s->rise, trigger)) return;
  s->value = in;
  s->taken = 1;
}

/// Time since the last trigger before this frame, so that it is the whole interval in the frame of a trigger;
/// before the first one, `initial` plus the time since the start.
typedef struct tactus_interval {
  tactus_rise rise;
  int triggered;
  long long frames;
} tactus_interval;

/// [s]
static inline tactus_real tactus_interval_value(const tactus_interval* s, tactus_real initial,
                                                tactus_real rate) {
  return (tactus_real)s->frames / rate + (s->triggered ? 0.0 : tactus_clamp(initial, 0.0, 1e9));
}
static inline void tactus_interval_pass(tactus_interval* s, tactus_real trigger) {
  ++s->frames;
  if (!tactus_rise_step(&s->rise, trigger)) return;
  s->triggered = 1;
  s->frames = 1;
}
