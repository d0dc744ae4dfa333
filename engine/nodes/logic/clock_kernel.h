#pragma once

// Thread: [realtime].

#include "engine/dsp/envelopes/envelope_kernel.h"

/// Steps at a tempo, in pairs: with swing s the first step of a pair takes s of the time of both, the second
/// 1 - s. The sum of the steps per second over the frames, `passed`, reaches `rate` after an even step: sums
/// of whole numbers are exact, so a step of a whole number of frames never comes a frame late.
typedef struct tactus_clock {
  tactus_rise reset;
  int started, second;  ///< of a pair
  tactus_real passed;   ///< since the last step, in frames times steps per second
  tactus_real count;    ///< steps since the reset
  tactus_real phase;    ///< of the step, 0 to 1
} tactus_clock;

/// 1 in the frame of a step; the first is the first frame, and the frame of a reset. `speed`: steps per
/// second, limited to a tenth of the rate. `swing`: 0.1 to 0.9.
static inline int tactus_clock_step(tactus_clock* s, tactus_real speed, tactus_real swing, tactus_real reset,
                                    tactus_real rate) {
  const tactus_real share = tactus_clamp(swing, 0.1, 0.9);
  tactus_real length = 2.0 * rate * (s->second ? 1.0 - share : share);
  int fires = 0;
  if (tactus_rise_step(&s->reset, reset)) s->started = 0;
  if (!s->started) {
    s->started = fires = 1;
    s->second = 0;
    s->passed = s->count = 0;
    length = 2.0 * rate * share;
  } else if (s->passed >= length * (1.0 - 1e-9)) {
    fires = 1;
    s->passed = tactus_max(0.0, s->passed - length);
    s->second = !s->second;
    ++s->count;
    length = 2.0 * rate * (s->second ? 1.0 - share : share);
  }
  s->phase = tactus_min(1.0, s->passed / length);
  s->passed += tactus_clamp(speed, 0.0, 0.1 * rate);
  return fires;
}
