#pragma once

// Thread: [realtime].

#include "engine/dsp/kernel.h"

/// F = -b v, the force on the device: Berdahl, Steiner & Oldham, NIME 2008, section 6.1.1.
static inline tactus_real tactus_damper_force(tactus_real velocity, tactus_real damping) {
  return -tactus_max(0.0, damping) * velocity;
}
