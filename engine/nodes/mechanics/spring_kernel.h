#pragma once

// Thread: [realtime].

#include "engine/dsp/kernel.h"

/// F = -k (x - rest), the force on the device: Berdahl, Steiner & Oldham, "Practical hardware and
/// algorithms for creating haptic musical instruments", NIME 2008, section 6.1.1. A force is positive in the
/// direction of positive positions.
static inline tactus_real tactus_spring_force(tactus_real position, tactus_real stiffness, tactus_real rest) {
  return -tactus_max(0.0, stiffness) * (position - rest);
}
