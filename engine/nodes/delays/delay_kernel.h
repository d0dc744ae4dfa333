#pragma once

// Thread: [realtime].

#include "engine/dsp/delays/taps_kernel.h"

/// What does not change of a delay: how many taps less one (0, 1, 3 or 5), the range of its times [s].
typedef struct tactus_delay {
  int order;
  tactus_real low, high, rate;
} tactus_delay;

/// A loop needs a tap in the past; where the delay is never below a frame, no tap is newer.
static inline int tactus_delay_least(const tactus_delay* s) {
  return s->order > 0 && tactus_delay_frames(s->low, s->rate) >= 1;
}

/// `line` holds the longest time and the taps.
static inline tactus_real tactus_delay_step(const tactus_delay* s, tactus_line* line, tactus_real in,
                                            tactus_real time) {
  const tactus_real inside = time > s->low ? tactus_min(time, s->high) : s->low;
  const tactus_real frames = tactus_delay_frames(inside, s->rate);
  const int newest = tactus_delay_newest(frames, s->order, tactus_delay_least(s));
  tactus_real weights[6] = {1};
  tactus_line_write(line, in);
  if (s->order > 0) tactus_lagrange(weights, s->order + 1, frames - newest);
  return s->order > 0 ? tactus_line_sum(line, newest + 1, weights, s->order + 1, 0)
                      : line->samples[(line->next - newest - 1) & (line->capacity - 1)];
}
