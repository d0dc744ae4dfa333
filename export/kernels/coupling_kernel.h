#pragma once

// Thread: [realtime].

#include "engine/dsp/kernel.h"

/// A contact or a bond that acts in the step that is being made, linear in the motion of its ends:
///   force = static_force + resistance * motion,   motion: of its lower end towards the upper one [m].
typedef struct tactus_coupling {
  int coupling;              ///< contacts, then bonds
  int bounces;               ///< over within the step: the damper of its restitution
  int released;              ///< it would have to pull
  tactus_real slope;         ///< of the root of the energy, over the step
  tactus_real static_force;  ///< without motion [N]
  tactus_real resistance;    ///< [N/m]
  tactus_real free_motion;   ///< without this force
  tactus_real motion;        ///< with all forces
  tactus_real force;         ///< [N]
} tactus_coupling;

static inline tactus_coupling tactus_coupling_of(int coupling) {
  tactus_coupling link;
  link.coupling = coupling;
  link.bounces = link.released = 0;
  link.slope = link.static_force = link.resistance = link.free_motion = link.motion = link.force = 0;
  return link;
}

/// L L^T x = b for the first `n` rows of 1 + a positive semidefinite matrix; `matrix` is overwritten.
static inline void tactus_solve_cholesky(tactus_real* matrix, tactus_real* b, int n) {
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j <= i; ++j) {
      tactus_real sum = matrix[i * n + j];
      for (int l = 0; l < j; ++l) sum -= matrix[i * n + l] * matrix[j * n + l];
      matrix[i * n + j] = i == j ? sqrt(tactus_max(1, sum)) : sum / matrix[j * n + j];
    }
    for (int j = 0; j < i; ++j) b[i] -= matrix[i * n + j] * b[j];
    b[i] /= matrix[i * n + i];
  }
  for (int i = n; i-- > 0;) {
    b[i] /= matrix[i * n + i];
    for (int j = 0; j < i; ++j) b[j] -= matrix[i * n + j] * b[i];
  }
}

/// y += by x
static inline void tactus_add_row(tactus_real* y, const tactus_real* x, tactus_real by, int count) {
  for (int i = 0; i < count; ++i) y[i] += by * x[i];
}

/// A potential well of the length a and the depth E:  V = -E / w,  w = sqrt(1 + s^2),  s = n / a.
typedef struct tactus_well {
  tactus_real length, depth;
} tactus_well;

static inline tactus_real tactus_well_width(const tactus_well* law, tactus_real n) {
  return sqrt(1 + (n / law->length) * (n / law->length));
}
static inline tactus_real tactus_well_root(const tactus_well* law, tactus_real n) {
  const tactus_real s = n / law->length, w = tactus_well_width(law, n);
  return sqrt(2 * law->depth) * s / sqrt(w * (1 + w));
}
static inline tactus_real tactus_well_root_slope(const tactus_well* law, tactus_real n) {
  const tactus_real w = tactus_well_width(law, n);
  return 0.5 * sqrt(2 * law->depth) / law->length * sqrt(w * (1 + w)) / (w * w * w);
}
static inline tactus_real tactus_well_force(const tactus_well* law, tactus_real n) {
  const tactus_real s = n / law->length, w = tactus_well_width(law, n);
  return law->depth / law->length * s / (w * w * w);
}
/// (root(to) - root(from)) / (to - from), without loss of digits where the ends are close to each other.
static inline tactus_real tactus_well_chord(const tactus_well* law, tactus_real from, tactus_real to) {
  const tactus_real s = from / law->length, t = to / law->length;
  const tactus_real v = tactus_well_width(law, from), w = tactus_well_width(law, to);
  if (s * t > 0)
    return 2 * law->depth / law->length * (s + t) /
           (v * w * (v + w) * (tactus_well_root(law, from) + tactus_well_root(law, to)));
  if (from != to) return (tactus_well_root(law, to) - tactus_well_root(law, from)) / (to - from);
  return tactus_well_root_slope(law, from);
}
