#pragma once

// Thread: [realtime].

#include "engine/dsp/curves/curve_kernel.h"
#include "engine/dsp/envelopes/envelope_kernel.h"

/// Plays a recording from its start, at any speed. Before and behind the recording lies silence:
/// the last sample fades into it within one sample of the recording.
typedef struct tactus_sample {
  tactus_rise rise;
  int playing;
  tactus_real position;  ///< in samples of the recording
} tactus_sample;

static inline void tactus_sample_start(tactus_sample* s) {
  s->playing = 1;
  s->position = 0;
}

static inline tactus_real tactus_sample_value(const tactus_real* samples, int count, int index) {
  return index >= 0 && index < count ? samples[index] : 0.0;
}

/// The value of this frame; then moves on by `increment` >= 0 samples. `cubic`: Catmull-Rom, else linear.
static inline tactus_real tactus_sample_read(tactus_sample* s, const tactus_real* samples, int count,
                                             tactus_real increment, int cubic) {
  int index;
  tactus_real at, here, next;
  s->playing = s->playing && s->position < (tactus_real)count;
  if (!s->playing) return 0;
  index = (int)s->position;
  at = s->position - (tactus_real)index;
  s->position += increment;
  here = tactus_sample_value(samples, count, index);
  next = tactus_sample_value(samples, count, index + 1);
  if (!cubic) return here + at * (next - here);
  return tactus_catmull_rom(tactus_sample_value(samples, count, index - 1), here, next,
                            tactus_sample_value(samples, count, index + 2), at);
}
