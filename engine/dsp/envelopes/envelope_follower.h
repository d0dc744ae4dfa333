#pragma once

#include <algorithm>
#include <cmath>

#include "engine/core/realtime.h"

namespace tactus {

/// Peak envelope:  r = |in|,  e += (r > e ? 1 - a : 1 - d) * (r - e),  where a and d are what the attack and
/// the release keep in a frame (`TimeConstant`). Written without a branch: while the attack is the faster
/// one, its answer is the larger one exactly when r > e, so e = max of both; else e = min of both. Each
/// answer is keep * e + (1 - keep) * r: one FMA in the chain.
struct EnvelopeFollower {
  double envelope = 0;

  double step(double in, double attack_keep, double release_keep) {
    const double rectified = std::abs(in);
    const double attack = fused_multiply_add(attack_keep, envelope, (1.0 - attack_keep) * rectified);
    const double release = fused_multiply_add(release_keep, envelope, (1.0 - release_keep) * rectified);
    envelope = attack_keep <= release_keep ? std::max(attack, release) : std::min(attack, release);
    return envelope;
  }

  /// `frames` steps with the same times.
  void run(const double* in, double* out, int frames, double attack_keep, double release_keep) {
    EnvelopeFollower now = *this;
    for (int n = 0; n < frames; ++n) out[n] = now.step(in[n], attack_keep, release_keep);
    *this = now;
  }
};

}  // namespace tactus
