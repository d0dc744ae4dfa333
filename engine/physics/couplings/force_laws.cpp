#include "engine/physics/couplings/force_laws.h"

#include <algorithm>

#include "engine/physics/couplings/contact_kernel.h"

namespace tactus {
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

double restitution_of(double loss_speed) noexcept { return tactus_restitution_of(loss_speed); }

double stored_at_deepest(double loss_speed) noexcept { return tactus_stored_at_deepest(loss_speed); }

}  // namespace tactus
