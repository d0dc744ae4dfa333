#pragma once

// Thread: [realtime].

#include "engine/dsp/envelopes/envelope_kernel.h"

/// A pulse that jumps to a level and decays:  out[n] = level * keep^n,  n frames after its start;
/// 0 once n has reached `length` frames (0: never).
typedef struct tactus_pulse {
  tactus_real value;
  long long age;
} tactus_pulse;

static inline void tactus_pulse_start(tactus_pulse* s, tactus_real level) {
  s->value = level;
  s->age = 0;
}

/// The value of this frame; then one frame on, without an end.
static inline tactus_real tactus_pulse_fall(tactus_real* value, tactus_real keep) {
  const tactus_real now = *value;
  *value = now * keep;
  return now;
}
static inline tactus_real tactus_pulse_step(tactus_pulse* s, tactus_real keep, tactus_real length_frames) {
  if (length_frames > 0 && (tactus_real)s->age + 0.5 >= length_frames) s->value = 0;
  ++s->age;
  return tactus_pulse_fall(&s->value, keep);
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
  if (tactus_rise_step(&s->rise, trigger)) tactus_pulse_start(&s->pulse, level);
  return tactus_pulse_step(&s->pulse, tactus_time_constant_keep(&s->time, time, rate), length * rate);
}

/// Attack, decay, sustain, release. In each frame, e being the value of the frame before:
///   gate rises:      attack from where it is
///   attack:          e + rise, but not above 1; at 1 the decay begins
///   decay, sustain:  sustain + decay_keep * (e - sustain)
///   gate low:        release_keep * e
typedef struct tactus_adsr {
  tactus_real value;
  int gate_high, attacking;
  tactus_time_constant decay, release;
} tactus_adsr;

/// `rise` is 1 / (rate * attack), the `keep`s are those of `tactus_keep`.
static inline tactus_real tactus_adsr_move(tactus_adsr* s, tactus_real gate, tactus_real rise,
                                           tactus_real decay_keep, tactus_real sustain,
                                           tactus_real release_keep) {
  const int high = gate >= 0.5;
  if (high && !s->gate_high) s->attacking = 1;
  s->gate_high = high;
  if (!high) {
    s->value *= release_keep;
  } else if (s->attacking) {
    s->value = tactus_min(1.0, s->value + rise);
    s->attacking = s->value < 1.0;
  } else {
    s->value = tactus_fma(decay_keep, s->value - sustain, sustain);
  }
  return s->value;
}

/// Times in seconds.
static inline tactus_real tactus_adsr_step(tactus_adsr* s, tactus_real gate, tactus_real attack,
                                           tactus_real decay, tactus_real sustain, tactus_real release,
                                           tactus_real rate) {
  // In this order: the division runs beside the exponentials.
  const tactus_real attack_frames = attack * rate;
  const tactus_real rise = attack_frames > 1 ? 1 / attack_frames : 1;
  const tactus_real decay_keep = tactus_time_constant_keep(&s->decay, decay, rate);
  const tactus_real release_keep = tactus_time_constant_keep(&s->release, release, rate);
  return tactus_adsr_move(s, gate, rise, decay_keep, tactus_clamp(sustain, 0.0, 1.0), release_keep);
}
