#pragma once

// Thread: [realtime].

#include "engine/dsp/kernel.h"

/// What an exponential keeps in one frame, e^(-1 / (rate seconds)); 0 for seconds <= 0: at once.
static inline tactus_real tactus_keep(tactus_real seconds, tactus_real rate) {
  return seconds > 0 ? exp(-1.0 / (rate * seconds)) : 0.0;
}

/// The same, computed only when `seconds` changes, so that it may be asked every frame.
typedef struct tactus_time_constant {
  tactus_real seconds, keep;
} tactus_time_constant;

static inline tactus_real tactus_time_constant_keep(tactus_time_constant* s, tactus_real seconds,
                                                    tactus_real rate) {
  if (seconds != s->seconds) {
    s->seconds = seconds;
    s->keep = tactus_keep(seconds, rate);
  }
  return s->keep;
}
