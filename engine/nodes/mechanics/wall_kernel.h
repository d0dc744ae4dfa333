#pragma once

// Thread: [realtime].

#include "engine/dsp/kernel.h"

/// Force into the wall, k (x - at) + b v, before the part that would pull is cut off.
static inline tactus_real tactus_wall_push(tactus_real position, tactus_real velocity, tactus_real stiffness,
                                           tactus_real damping, tactus_real at) {
  return tactus_max(0.0, stiffness) * (position - at) + tactus_max(0.0, damping) * velocity;
}

/// F = x > at ? -max(0, k (x - at) + b v) : 0. The damper cannot make the wall sticky. Berdahl,
/// Steiner & Oldham, NIME 2008, section 6.1.2. Computed in any case, so that frames can be vectorised.
static inline tactus_real tactus_wall_force(tactus_real position, tactus_real velocity, tactus_real stiffness,
                                            tactus_real damping, tactus_real at) {
  const tactus_real pushed = tactus_max(0.0, tactus_wall_push(position, velocity, stiffness, damping, at));
  return position > at ? -pushed : 0.0;
}
