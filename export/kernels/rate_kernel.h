#pragma once

// Thread: [realtime].

#include "engine/dsp/kernel.h"

// The borders of a part that runs at 1/R of the rate: its frame m lies at frame R m outside, `position` is
// the frame number outside modulo R.

/// Into the part: the mean of the last R frames, or the largest of them.
typedef struct tactus_gather {
  tactus_real gathered;
  int started;
} tactus_gather;

static inline tactus_real tactus_gathered(tactus_gather* s, tactus_real in) {
  const tactus_real out = s->started ? s->gathered : in;
  s->started = 1;
  s->gathered = 0;
  return out;
}
/// What it returns counts where `position` is 0.
static inline tactus_real tactus_gather_mean(tactus_gather* s, tactus_real in, int position, int ratio) {
  // Shares of a mean are added up, not samples: those may be so large that their sum is none.
  s->gathered = s->gathered + in / ratio;
  return position == 0 ? tactus_gathered(s, in) : 0;
}
static inline tactus_real tactus_gather_trigger(tactus_gather* s, tactus_real in, int position) {
  s->gathered = tactus_max(s->gathered, in);
  return position == 0 ? tactus_gathered(s, in) : 0;
}

/// Out of the part: its last value, a line between its last two, or a trigger in the first of R frames.
typedef struct tactus_spread {
  tactus_real before, latest;
  int started;
} tactus_spread;

/// `in` is read where `position` is 0.
static inline void tactus_spread_take(tactus_spread* s, tactus_real in, int position) {
  if (position != 0) return;
  s->before = s->started ? s->latest : in;
  s->latest = in;
  s->started = 1;
}
static inline tactus_real tactus_spread_last(tactus_spread* s, tactus_real in, int position) {
  tactus_spread_take(s, in, position);
  return s->latest;
}
static inline tactus_real tactus_spread_line(tactus_spread* s, tactus_real in, int position, int ratio) {
  const tactus_real part = (tactus_real)position / ratio;
  tactus_spread_take(s, in, position);
  return (1 - part) * s->before + part * s->latest;
}
static inline tactus_real tactus_spread_trigger(tactus_spread* s, tactus_real in, int position) {
  tactus_spread_take(s, in, position);
  return position == 0 ? s->latest : 0;
}
