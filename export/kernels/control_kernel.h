#pragma once

// Thread: [realtime].

#include "engine/dsp/kernel.h"

/// A value that moves to where it is sent in so many frames, on a straight line from where it was.
typedef struct tactus_control {
  tactus_real value;  ///< in this frame
  tactus_real from, to;
  long frames, passed;  ///< of the way
} tactus_control;

static inline void tactus_control_start(tactus_control* s, tactus_real value) {
  s->value = s->from = s->to = value;
  s->frames = s->passed = 0;
}

static inline tactus_real tactus_control_share(const tactus_control* s) {
  return (tactus_real)s->passed / (tactus_real)s->frames;
}
static inline tactus_real tactus_control_at(const tactus_control* s) {
  return s->passed >= s->frames ? s->to : s->from + (s->to - s->from) * tactus_control_share(s);
}

/// One frame on. 1 while it moves: also in the frame in which it begins to, and until a frame with the value
/// of the one before. A `wanted` that is not finite is ignored.
static inline int tactus_control_step(tactus_control* s, tactus_real wanted, tactus_real low,
                                      tactus_real high, long frames) {
  const tactus_real target = tactus_is_finite(wanted) ? tactus_clamp(wanted, low, high) : s->to;
  const tactus_real before = s->value;
  if (s->passed < s->frames) ++s->passed;
  s->value = tactus_control_at(s);
  if (target != s->to) {
    s->from = s->value;
    s->to = target;
    s->frames = frames;
    s->passed = 0;
    s->value = tactus_control_at(s);
  }
  return s->value != before || s->passed < s->frames;
}

/// The same on a straight line in decibels, where both ends are positive.
static inline tactus_real tactus_control_decibel_at(const tactus_control* s) {
  if (!(s->from > 0 && s->to > 0) || s->passed >= s->frames) return tactus_control_at(s);
  return s->from * pow(s->to / s->from, tactus_control_share(s));
}
static inline int tactus_control_decibel_step(tactus_control* s, tactus_real wanted, tactus_real low,
                                              tactus_real high, long frames) {
  const tactus_real target = tactus_is_finite(wanted) ? tactus_clamp(wanted, low, high) : s->to;
  const tactus_real before = s->value;
  if (s->passed < s->frames) ++s->passed;
  s->value = tactus_control_decibel_at(s);
  if (target != s->to) {
    s->from = s->value;
    s->to = target;
    s->frames = frames;
    s->passed = 0;
    s->value = tactus_control_decibel_at(s);
  }
  return s->value != before || s->passed < s->frames;
}
