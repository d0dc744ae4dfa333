#pragma once

// Thread: [realtime].

#include "engine/dsp/kernel.h"

/// Fires in the one frame in which a trigger signal rises through 0.5. Before the first frame the
/// signal counts as low, so that a signal which starts high fires at once.
typedef struct tactus_rise {
  int high;
} tactus_rise;

static inline int tactus_rise_step(tactus_rise* s, tactus_real trigger) {
  const int was_high = s->high;
  s->high = trigger >= 0.5;
  return s->high && !was_high;
}

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

/// Peak envelope:  r = |in|,  e += (r > e ? 1 - a : 1 - d) * (r - e),  where a and d are what the
/// attack and the release keep in a frame (`tactus_keep`). Written without a branch: while the attack is the
/// faster one, its result is the larger one exactly when r > e, so e = max of both; else e = min of both.
/// Each result is keep * e + (1 - keep) * r: one FMA in the chain.
typedef struct tactus_follower {
  tactus_real envelope;
} tactus_follower;

static inline tactus_real tactus_follower_step(tactus_follower* s, tactus_real in, tactus_real attack_keep,
                                               tactus_real release_keep) {
  const tactus_real rectified = fabs(in);
  const tactus_real attack = tactus_fma(attack_keep, s->envelope, (1.0 - attack_keep) * rectified);
  const tactus_real release = tactus_fma(release_keep, s->envelope, (1.0 - release_keep) * rectified);
  s->envelope = attack_keep <= release_keep ? tactus_max(attack, release) : tactus_min(attack, release);
  return s->envelope;
}

/// With times in seconds.
typedef struct tactus_envelope {
  tactus_time_constant attack, release;
  tactus_follower follower;
} tactus_envelope;

static inline tactus_real tactus_envelope_step(tactus_envelope* s, tactus_real in, tactus_real attack,
                                               tactus_real release, tactus_real rate) {
  return tactus_follower_step(&s->follower, in, tactus_time_constant_keep(&s->attack, attack, rate),
                              tactus_time_constant_keep(&s->release, release, rate));
}
