#pragma once

// Thread: [realtime].

#include "engine/dsp/envelopes/envelope_kernel.h"

#define TACTUS_EVENT_DELAY_MOST 64 /* triggers under way; further ones are left out */

/// Triggers under way, each with its own time and value.
typedef struct tactus_event_delay {
  tactus_rise rise;
  int count;
  long long left[TACTUS_EVENT_DELAY_MOST];  ///< frames until it is due
  tactus_real carried[TACTUS_EVENT_DELAY_MOST];
  tactus_real value;  ///< of the last trigger that came out
} tactus_event_delay;

/// 1 in a frame in which a trigger is due; of several the one that came in last sets `value`. `frames` is
/// read in the frame in which a trigger comes in.
static inline int tactus_event_delay_step(tactus_event_delay* s, tactus_real trigger, tactus_real frames,
                                          tactus_real value) {
  int fires = 0, kept = 0;
  for (int k = 0; k < s->count; ++k) {
    if (--s->left[k] <= 0) {
      fires = 1;
      s->value = s->carried[k];
    } else {
      s->left[kept] = s->left[k];
      s->carried[kept++] = s->carried[k];
    }
  }
  s->count = kept;
  if (tactus_rise_step(&s->rise, trigger)) {
    const long long wait = (long long)round(tactus_max(0.0, frames));
    if (wait == 0) {
      fires = 1;
      s->value = value;
    } else if (s->count < TACTUS_EVENT_DELAY_MOST) {
      s->left[s->count] = wait;
      s->carried[s->count++] = value;
    }
  }
  return fires;
}
