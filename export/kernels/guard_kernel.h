#pragma once

// Thread: [realtime]; tactus_switch_refresh [any].

#include "export/kernels/control_kernel.h"

/// Limits of an output, full scale = 1.
typedef struct tactus_limits {
  tactus_real ceiling;            ///< largest magnitude
  tactus_real largest_step;       ///< largest change from frame to frame, at least `spacing`
  tactus_real spacing;            ///< of the numbers below the ceiling; 0: too small to count
  long rise_frames, fall_frames;  ///< of the soft start and of the fade-out
} tactus_limits;

/// Last stage of an output. Within the limits, and with the gain at 1, it changes nothing:
///
///   x' = gain clamp(x, -ceiling, ceiling),   0 where x is not finite
///   y[n] = clamp(x'[n], y[n-1] - largest_step, y[n-1] + largest_step), rounded towards y[n-1]
typedef struct tactus_guard {
  tactus_control gain;
  tactus_real last;
} tactus_guard;

/// The largest number up to from + largest_step: a sum that was rounded upwards is one `spacing` less.
static inline tactus_real tactus_highest(tactus_real from, const tactus_limits* limits) {
  const tactus_real to = from + limits->largest_step;
  return to - from > limits->largest_step ? to - limits->spacing : to;
}

static inline tactus_real tactus_guard_step(tactus_guard* s, const tactus_limits* limits, int open,
                                            tactus_real x) {
  tactus_real y = tactus_is_finite(x) ? tactus_clamp(x, -limits->ceiling, limits->ceiling) : 0;
  tactus_control_step(&s->gain, open ? 1 : 0, 0, 1, open ? limits->rise_frames : limits->fall_frames);
  y = tactus_clamp(s->gain.value * y, -tactus_highest(-s->last, limits), tactus_highest(s->last, limits));
  s->last = tactus_clamp(y, -limits->ceiling, limits->ceiling);
  return s->last;
}

/// Dead man's switch: who is to refresh it may do so from another context, such as a main loop beside an
/// interrupt; a byte is written at once on every processor.
typedef struct tactus_switch {
  volatile unsigned char refreshes;
  unsigned char seen;
  long left;  ///< frames for which the last refresh still counts; none before the first one
} tactus_switch;

static inline void tactus_switch_refresh(tactus_switch* s) {
  s->refreshes = (unsigned char)(s->refreshes + 1);
}

/// One frame on. 0: the last refresh is `patience` frames or more old.
static inline int tactus_switch_step(tactus_switch* s, long patience) {
  const unsigned char refreshes = s->refreshes;
  int open;
  if (refreshes != s->seen) s->left = patience;
  s->seen = refreshes;
  open = s->left > 0;
  if (open) --s->left;
  return open;
}
