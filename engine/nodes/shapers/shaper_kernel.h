#pragma once

// Thread: [realtime].

#include "engine/dsp/kernel.h"

/// `low` wins where it is above `high`.
static inline tactus_real tactus_clip(tactus_real in, tactus_real low, tactus_real high) {
  return tactus_max(low, tactus_min(high, in));
}

/// From `a` (t = 0) to `b` (t = 1) on a straight line, or with equal power: gains cos and sin of a quarter
/// turn.
static inline tactus_real tactus_crossfade(tactus_real a, tactus_real b, tactus_real t, int equal_power) {
  const tactus_real at = tactus_clamp(t, 0.0, 1.0);
  if (!equal_power) return a + (b - a) * at;
  return a * cos(1.5707963267948966 * at) + b * sin(1.5707963267948966 * at);
}

/// The sum of `count` lanes, which it overwrites: lane k takes in lanes k + 8, k + 16, ..., then what is left
/// is added in halves: k and k + 4, k and k + 2, k and k + 1.
static inline tactus_real tactus_mix(tactus_real* lanes, int count) {
  for (int k = 8; k < count; ++k) lanes[k % 8] += lanes[k];
  if (count > 8) count = 8;
  for (int half = 4; half > 0; half /= 2) {
    for (int k = 0; k < half && k + half < count; ++k) lanes[k] += lanes[k + half];
    if (count > half) count = half;
  }
  return lanes[0];
}

/// The play operator: a rod in a slot of the given width, pushed by the ends of the slot.
typedef struct tactus_hysteresis {
  tactus_real last;
} tactus_hysteresis;

static inline tactus_real tactus_hysteresis_step(tactus_hysteresis* s, tactus_real in, tactus_real width) {
  const tactus_real half = 0.5 * tactus_max(0.0, width);
  s->last = tactus_clamp(s->last, in - half, in + half);
  return s->last;
}
