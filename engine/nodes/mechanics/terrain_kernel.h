#pragma once

// Thread: [realtime].

#include "engine/dsp/curves/curve_kernel.h"

// The value of a tactus_cubic_point is the height z of a profile at a place.

/// z = -h exp(-x^2 / 2 s^2): a valley of depth h. With weight w it feels like a spring of stiffness k = w h /
/// s^2 near its centre, F = -k x exp(-x^2 / 2 s^2); the peak force 0.60653 k s lies at x = +-s.
static inline tactus_cubic_point tactus_terrain_detent(tactus_real x, tactus_real depth, tactus_real sigma) {
  const tactus_real u = x / sigma, bell = exp(-0.5 * u * u);
  tactus_cubic_point shape;
  shape.value = -depth * bell;
  shape.slope = depth * x / (sigma * sigma) * bell;
  shape.curvature = depth / (sigma * sigma) * (1 - u * u) * bell;
  return shape;
}

/// z = h cos(2 pi x / l): the force is (2 pi w h / l) sin(2 pi x / l), the largest stiffness 4 pi^2 w h /
/// l^2.
static inline tactus_cubic_point tactus_terrain_sine(tactus_real x, tactus_real height, tactus_real length) {
  const tactus_real k = 6.283185307179586 / length;
  tactus_cubic_point shape;
  shape.value = height * cos(k * x);
  shape.slope = -height * k * sin(k * x);
  shape.curvature = -k * k * shape.value;
  return shape;
}

/// F = -w dz/dx: what a mass of weight `w` feels that slides without friction over the profile. Berdahl,
/// Steiner & Oldham, NIME 2008, section 6.1.3.
static inline tactus_real tactus_terrain_force(tactus_real weight, tactus_real slope) {
  return -tactus_max(0.0, weight) * slope;
}

typedef enum tactus_terrain_profile {
  TACTUS_TERRAIN_DETENT,
  TACTUS_TERRAIN_SINE,
  TACTUS_TERRAIN_POINTS  ///< a cubic, level outside; makes no use of height and length
} tactus_terrain_profile;

#define TACTUS_TERRAIN_SHORTEST 1e-6  ///< length [m]

/// `curve` only for points.
static inline tactus_cubic_point tactus_terrain_at(tactus_terrain_profile profile, const tactus_curve* curve,
                                                   tactus_real x, tactus_real height, tactus_real length) {
  if (profile == TACTUS_TERRAIN_POINTS) return tactus_cubic_at(curve, x);
  height = tactus_max(0.0, height);
  length = tactus_max(TACTUS_TERRAIN_SHORTEST, length);
  return profile == TACTUS_TERRAIN_SINE ? tactus_terrain_sine(x, height, length)
                                        : tactus_terrain_detent(x, height, length);
}
