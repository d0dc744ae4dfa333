#pragma once

// Thread: [realtime].

#include "engine/dsp/generators/noise_kernel.h"

/// A random walk between -1 and 1, reflected at both ends:
///   p[n+1] = fold(p[n] + g[n] / sqrt(rate time)),  p[0] = 0,  g normal,
/// so that its mean square distance from where it was grows by t / time until it feels the ends, and every
/// value is as likely as any other in the long run. Source: Feller, An Introduction to Probability Theory,
/// 1968, chapter XIV.
typedef struct tactus_random_walk {
  tactus_real position;
} tactus_random_walk;

/// As light between two mirrors, at -1 and 1.
static inline tactus_real tactus_fold(tactus_real x) {
  const tactus_real turns = 0.25 * (x + 1.0);
  return 1.0 - fabs(4.0 * (turns - floor(turns)) - 2.0);
}

/// The position of this frame; then moves on. `time` in seconds, limited to 1 ms to a day.
static inline tactus_real tactus_random_walk_step(tactus_random_walk* s, tactus_noise_bits key,
                                                  tactus_noise_bits frame, tactus_real time,
                                                  tactus_real rate) {
  const tactus_real now = s->position;
  s->position = tactus_fold(now + tactus_noise_gaussian(key, frame) /
                                      sqrt(tactus_max(1.0, rate * tactus_clamp(time, 0.001, 86400.0))));
  return now;
}
