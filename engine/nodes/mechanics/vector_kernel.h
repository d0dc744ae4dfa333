#pragma once

// Thread: [realtime].

#include "engine/dsp/kernel.h"

// Vectors with three axes.

static inline tactus_real tactus_dot(const tactus_real* a, const tactus_real* b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
static inline void tactus_cross(const tactus_real* a, const tactus_real* b, tactus_real* product) {
  product[0] = a[1] * b[2] - a[2] * b[1];
  product[1] = a[2] * b[0] - a[0] * b[2];
  product[2] = a[0] * b[1] - a[1] * b[0];
}
