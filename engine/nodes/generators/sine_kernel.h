#pragma once

// Thread: [realtime].

#include "engine/dsp/generators/phasor_kernel.h"

/// Frequency in Hz, phase in radians.
static inline tactus_real tactus_sine_step(tactus_phasor* s, tactus_real frequency, tactus_real phase,
                                           tactus_real level, tactus_real rate) {
  const tactus_real turns = tactus_phasor_step(s, frequency / rate);
  return level * sin(6.283185307179586 * turns + phase);
}
