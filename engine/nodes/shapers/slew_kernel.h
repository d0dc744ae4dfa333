#pragma once

// Thread: [realtime].

#include "engine/dsp/kernel.h"

/// Follows `in` no faster than `rise` and `fall` [1/s]; `frame_s` is the time of one frame.
typedef struct tactus_slew {
  tactus_real last;
} tactus_slew;

static inline tactus_real tactus_slew_step(tactus_slew* s, tactus_real in, tactus_real rise, tactus_real fall,
                                           tactus_real frame_s) {
  // Signals may be outside the declared range, which constants cannot be.
  const tactus_real up = tactus_max(0.0, rise) * frame_s;
  const tactus_real down = tactus_max(0.0, fall) * frame_s;
  s->last = tactus_clamp(in, s->last - down, s->last + up);
  return s->last;
}
