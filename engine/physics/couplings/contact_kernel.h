#pragma once

// Thread: [any].

#include "engine/dsp/kernel.h"

/// e of the product r v >= 0 of a Hunt-Crossley loss and an approach speed:  rv - ln(1 + rv) = -e rv - ln(1 -
/// e rv).  Newton's method for l = -ln(1 - e rv):  l - (1 - e^-l) = h, h = rv - ln(1 + rv), a convex function
/// whose zero lies below h + sqrt(2 h).
static inline tactus_real tactus_restitution_of(tactus_real loss_speed) {
  tactus_real h, l;
  // Differences of nearly equal numbers give way to the first two terms of their series.
  if (loss_speed < 1e-5) return 1 - 2.0 / 3.0 * loss_speed;
  h = loss_speed - log1p(loss_speed);
  l = h + sqrt(2 * h);
  for (int i = 0; i < 8; ++i) l -= (l + expm1(-l) - h) / -expm1(-l);
  return -expm1(-l) / loss_speed;
}

/// What a contact has stored at its deepest, of m v^2:  (rv - ln(1 + rv)) / (rv)^2, 1/2 without a loss.
static inline tactus_real tactus_stored_at_deepest(tactus_real loss_speed) {
  if (loss_speed < 1e-5) return 0.5 - loss_speed / 3;
  return (loss_speed - log1p(loss_speed)) / (loss_speed * loss_speed);
}
