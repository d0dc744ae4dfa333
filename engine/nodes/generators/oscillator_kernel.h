#pragma once

// Thread: [realtime].

#include "engine/dsp/curves/curve_kernel.h"
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

/// Frequency in Hz, phase in radians.
static inline tactus_real tactus_sine_step(tactus_phasor* s, tactus_real frequency, tactus_real phase,
                                           tactus_real level, tactus_real rate) {
  const tactus_real turns = tactus_phasor_step(s, frequency / rate);
  return level * sin(6.283185307179586 * turns + phase);
}

/// One period of a wave, read at any phase, 0 <= turns <= 1. Not band-limited: partials above half
/// the sample rate fold back, so a table for high notes must hold few partials. count > 0.
static inline tactus_real tactus_wavetable_at(const tactus_real* period, int count, tactus_real turns,
                                              int cubic) {
  const tactus_real position = turns * (tactus_real)count;
  const int index = position > 0 ? (int)position : 0;  // 0 where it is not a number, as the result is
  const tactus_real at = position - (tactus_real)index;
  const tactus_real here = period[index % count], next = period[(index + 1) % count];
  if (!cubic) return here + at * (next - here);
  return tactus_catmull_rom(period[(index + count - 1) % count], here, next, period[(index + 2) % count], at);
}

/// Frequency in Hz, phase in radians.
static inline tactus_real tactus_wavetable_step(tactus_phasor* s, const tactus_real* period, int count,
                                                int cubic, tactus_real frequency, tactus_real phase,
                                                tactus_real level, tactus_real rate) {
  tactus_real turns = tactus_phasor_step(s, frequency / rate) + phase / 6.283185307179586;
  turns -= floor(turns);
  return level * tactus_wavetable_at(period, count, turns, cubic);
}
