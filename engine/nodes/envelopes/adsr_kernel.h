#pragma once

// Thread: [realtime].

#include "engine/dsp/envelopes/envelope_kernel.h"

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
