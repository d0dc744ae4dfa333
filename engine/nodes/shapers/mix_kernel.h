#pragma once

// Thread: [realtime].

#include "engine/dsp/kernel.h"

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
