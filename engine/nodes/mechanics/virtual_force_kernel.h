#pragma once

// Thread: [realtime].

#include "engine/dsp/kernel.h"

/// F = -k (x - rest), the force on the device: Berdahl, Steiner & Oldham, "Practical hardware and
/// algorithms for creating haptic musical instruments", NIME 2008, section 6.1.1. A force is positive in the
/// direction of positive positions.
static inline tactus_real tactus_spring_force(tactus_real position, tactus_real stiffness, tactus_real rest) {
  return -tactus_max(0.0, stiffness) * (position - rest);
}

/// F = -b v, the force on the device: Berdahl, Steiner & Oldham, NIME 2008, section 6.1.1.
static inline tactus_real tactus_damper_force(tactus_real velocity, tactus_real damping) {
  return -tactus_max(0.0, damping) * velocity;
}

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
