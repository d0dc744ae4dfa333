#pragma once

// Thread: [realtime].

#include "engine/dsp/kernel.h"

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

/// `frames` steps with the same times.
static inline void tactus_follower_run(tactus_follower* s, const tactus_real* in, tactus_real* out,
                                       int frames, tactus_real attack_keep, tactus_real release_keep) {
  tactus_follower now = *s;
  for (int n = 0; n < frames; ++n) out[n] = tactus_follower_step(&now, in[n], attack_keep, release_keep);
  *s = now;
}
