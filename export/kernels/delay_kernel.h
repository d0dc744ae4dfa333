#pragma once

// Thread: [realtime].

#include "engine/dsp/delays/taps_kernel.h"

/// Where the taps of a delay lie, aimed anew only when the time changes.
typedef struct tactus_aim {
  tactus_real seconds;
  int aimed, newest;
  tactus_real weights[6];
} tactus_aim;

static inline void tactus_aim_at(tactus_aim* s, const tactus_delay* range, int order, tactus_real time) {
  const tactus_real seconds = tactus_delay_inside(range, time);
  if (s->aimed && seconds == s->seconds) return;
  s->seconds = seconds;
  s->aimed = 1;
  s->newest = tactus_delay_aim(range, order, seconds, s->weights);
}

/// The output of the frame that was written `written` frames ago (1: the last one; 0: the one to come).
static inline tactus_real tactus_aim_read(const tactus_aim* s, int order, const tactus_line* line,
                                          int written) {
  const tactus_real* tap = tactus_line_tap(line, s->newest + written, order);
  return order > 0 ? tactus_tap_sum(tap, s->weights, order + 1, 0) : *tap;
}
