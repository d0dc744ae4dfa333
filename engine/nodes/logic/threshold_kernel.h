#pragma once

// Thread: [realtime].

#include "engine/dsp/kernel.h"

/// A comparator with hysteresis (Schmitt trigger): high from the frame in which `in` reaches
/// `level`, low from the frame in which it falls below `level - hysteresis`. It fires once for each time it
/// was low: when `in` is at `level` or above and `hold` is over.
typedef struct tactus_threshold {
  int high, fired;  ///< `fired`: not low since it last fired
  long long wait;   ///< frames until it may fire again
} tactus_threshold;

/// 1 in the frame in which it fires; leaves out `high`. hysteresis, hold_frames: 0 and above.
static inline int tactus_threshold_fires(tactus_threshold* s, tactus_real in, tactus_real level,
                                         tactus_real hysteresis, tactus_real hold_frames) {
  if (s->wait > 0) --s->wait;
  if (s->fired) {
    s->fired = in >= level - hysteresis;
    return 0;  // at or above the level it is not released
  }
  if (!(in >= level) || s->wait > 0) return 0;
  s->fired = 1;
  s->wait = (long long)round(hold_frames);
  return 1;
}

/// The same with `high`.
static inline int tactus_threshold_step(tactus_threshold* s, tactus_real in, tactus_real level,
                                        tactus_real hysteresis, tactus_real hold_frames) {
  s->high = in >= (s->high ? level - hysteresis : level);
  return tactus_threshold_fires(s, in, level, hysteresis, hold_frames);
}

/// `count` frames that change nothing.
static inline void tactus_threshold_pass(tactus_threshold* s, int count) {
  s->wait = s->wait > count ? s->wait - count : 0;
}
