#include "engine/physics/couplings/friction_law.h"

#include <algorithm>

namespace tactus {
namespace {

/// The largest speed v in (0, free] where  v (1 + y c) + y N mu(v) = free;  below 0 if there is none. The
/// left side is convex, so Newton's steps from the right come down to its last root and never pass it.
double sliding_speed(const FrictionLaw& law, double viscous, double normal, double free,
                     double mobility) noexcept {
  constexpr int kMostSteps = 60;
  const double own = 1.0 + mobility * viscous, slowing = mobility * normal;
  double v = free / own;
  for (int i = 0; i < kMostSteps; ++i) {
    const double excess = v * own + slowing * law.coefficient(v) - free;
    if (excess <= 0.0) return v;
    const double slope = own + slowing * law.slope(v);
    if (slope <= 0.0) return -1.0;
    const double next = v - excess / slope;
    if (next <= 0.0) return -1.0;
    if (v - next <= 1e-15 * v) return next;
    v = next;
  }
  return v;
}

}  // namespace

FrictionForce solve_friction(const FrictionLaw& law, double viscous, double normal, double free,
                             double mobility, int sliding, double stopping) noexcept {
  normal = std::max(0.0, normal);
  const double speed = std::abs(free), sign = free < 0.0 ? -1.0 : 1.0;
  const auto slide = [&](double v) {
    return FrictionForce{sign * (normal * law.coefficient(v) + viscous * v), sign * v};
  };
  if (mobility <= 0.0) return speed == 0.0 ? FrictionForce{} : slide(speed);
  const bool can_hold = speed <= mobility * normal * law.holding();
  const bool slid = sliding != 0 && (sliding > 0) == (free > 0.0);
  if (!can_hold || slid) {
    const double v = sliding_speed(law, viscous, normal, speed, mobility);
    if (v > 0.0) {
      // From the equation rather than from the curve: what slides and what pushes agree to the last bit.
      return {sign * (speed - v) / mobility, sign * v};
    }
  }
  const double stop = (free - stopping) / mobility;
  const bool stops = std::abs(stop) <= normal * law.holding() && stop * stopping >= 0.0;
  return {stops ? stop : free / mobility, 0.0};
}

}  // namespace tactus
