#pragma once

// Thread: [realtime].

#include "engine/dsp/envelopes/envelope_kernel.h"

/// A pulse that jumps to a level and decays:  out[n] = level * keep^n,  n frames after its start;
/// 0 once n has reached `length` frames (0: never).
typedef struct tactus_pulse {
  tactus_real value;
  long long age;
} tactus_pulse;

/// The value of this frame; then one frame on.
static inline tactus_real tactus_pulse_step(tactus_pulse* s, tactus_real keep, tactus_real length_frames) {
  tactus_real now;
  if (length_frames > 0 && (tactus_real)s->age + 0.5 >= length_frames) s->value = 0;
  now = s->value;
  s->value *= keep;
  ++s->age;
  return now;
}

/// `count` steps with the same arguments.
static inline void tactus_pulse_run(tactus_pulse* s, tactus_real* out, int count, tactus_real keep,
                                    tactus_real length_frames) {
  tactus_real now = s->value;
  if (length_frames > 0) {
    for (int n = 0; n < count; ++n) out[n] = tactus_pulse_step(s, keep, length_frames);
    return;
  }
  for (int n = 0; n < count; ++n) {
    out[n] = now;
    now *= keep;
  }
  s->value = now;
  s->age += count;
}

/// Such a pulse at each trigger.
typedef struct tactus_decay {
  tactus_rise rise;
  tactus_pulse pulse;
  tactus_time_constant time;
} tactus_decay;

static inline tactus_real tactus_decay_step(tactus_decay* s, tactus_real trigger, tactus_real time,
                                            tactus_real level, tactus_real length, tactus_real rate) {
  if (tactus_rise_step(&s->rise, trigger)) {
    s->pulse.value = level;
    s->pulse.age = 0;
  }
  return tactus_pulse_step(&s->pulse, tactus_time_constant_keep(&s->time, time, rate), length * rate);
}
