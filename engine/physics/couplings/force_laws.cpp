#include "engine/physics/couplings/force_laws.h"

#include <algorithm>

namespace tactus {
namespace {

// Below, differences of nearly equal numbers give way to the first two terms of their series.
constexpr double kSmallLoss = 1e-5;

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

ContactLaw::ContactLaw(double stiffness, double exponent)
    : slope_(std::sqrt(0.5 * stiffness * (exponent + 1.0))),
      two_over_a1_(2.0 / (exponent + 1.0)),
      half_power_(0.5 * (exponent - 1.0)),
      power_(exponent == 1.0   ? Power::Zero
             : exponent == 1.5 ? Power::Quarter
             : exponent == 2.0 ? Power::Half
             : exponent == 3.0 ? Power::One
                               : Power::Any) {}

double loss_for_restitution(double e) {
  e = std::clamp(e, 0.01, 1.0);
  // Small losses: e = 1 - (2/3) rv to first order; the equation itself would cancel there.
  if (1.0 - e < 1e-5) return 1.5 * (1.0 - e);
  // In terms of l = -ln(1 - e rv), because 1 - e rv comes down to 1e-42: rises through its only zero.
  const auto excess = [e](double l) {
    const double rv = -std::expm1(-l) / e;
    return (l - e * rv) - (rv - std::log1p(rv));
  };
  double low = 1e-9, high = 200.0;
  for (int i = 0; i < 100; ++i) {
    const double middle = 0.5 * (low + high);
    (excess(middle) > 0.0 ? high : low) = middle;
  }
  return -std::expm1(-low) / e;
}

/// Newton's method for l = -ln(1 - e rv):  l - (1 - e^-l) = h, h = rv - ln(1 + rv), a convex function whose
/// zero lies below h + sqrt(2 h).
double restitution_of(double loss_speed) noexcept {
  if (loss_speed < kSmallLoss) return 1.0 - 2.0 / 3.0 * loss_speed;
  const double h = loss_speed - std::log1p(loss_speed);
  double l = h + std::sqrt(2.0 * h);
  for (int i = 0; i < 8; ++i) l -= (l + std::expm1(-l) - h) / -std::expm1(-l);
  return -std::expm1(-l) / loss_speed;
}

double stored_at_deepest(double loss_speed) noexcept {
  if (loss_speed < kSmallLoss) return 0.5 - loss_speed / 3.0;
  return (loss_speed - std::log1p(loss_speed)) / (loss_speed * loss_speed);
}

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
  const bool sticks = std::abs(stop) <= normal * law.holding() && stop * stopping >= 0.0;
  return {sticks ? stop : free / mobility, 0.0};
}

}  // namespace tactus
