#pragma once

// Thread: [realtime].

#include "engine/dsp/envelopes/time_constant_kernel.h"

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
