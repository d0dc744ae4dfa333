#pragma once

// Thread: [any]
#include <cmath>

namespace tactus {

/// The conservative part of a contact: a power law of the indentation n [m], n > 0 in contact.
///   F = K n^a,   energy phi = K n^(a+1) / (a+1),   root psi = sqrt(2 phi)
/// With root' = dpsi/dn = sqrt(K (a+1)/2) n^((a-1)/2):  F = psi root'.
class ContactLaw {
 public:
  /// [any] stiffness > 0 [N/m^exponent], exponent >= 1.
  ContactLaw(double stiffness, double exponent);

  /// [realtime] All for n >= 0.
  double root_slope(double n) const noexcept { return slope_ * raise(n); }
  double root(double n) const noexcept { return root_slope(n) * n * two_over_a1_; }
  double force(double n) const noexcept { return force_from_slope(root_slope(n), n); }
  double energy(double n) const noexcept { return 0.5 * root(n) * root(n); }
  /// dF/dn [N/m], n > 0.
  double stiffness(double n) const noexcept { return (2.0 / two_over_a1_ - 1.0) * force(n) / n; }
  /// The force, when the slope is known already: saves the power.
  double force_from_slope(double slope, double n) const noexcept { return slope * slope * n * two_over_a1_; }

 private:
  // The exponents that occur (linear, Hertz, cone, cubic) need roots only, five times cheaper than pow.
  enum class Power { Zero, Quarter, Half, One, Any };

  double raise(double n) const noexcept {
    switch (power_) {
      case Power::Zero:
        return 1.0;
      case Power::Quarter:
        return std::sqrt(std::sqrt(n));
      case Power::Half:
        return std::sqrt(n);
      case Power::One:
        return n;
      case Power::Any:
        break;
    }
    return std::pow(n, half_power_);
  }

  double slope_, two_over_a1_, half_power_;
  Power power_;
};

/// The product r v of the Hunt-Crossley loss r and the approach speed v that makes a body leave at e v,
/// whatever its mass and the law's stiffness and exponent:  rv - ln(1 + rv) = -e rv - ln(1 - e rv). 0.01 <= e
/// <= 1 (clamped). Exact for bodies on which no other force acts.
double loss_for_restitution(double e);

/// The other way round: e of r v >= 0. [realtime]
double restitution_of(double loss_speed) noexcept;

/// What a contact has stored at its deepest, of m v^2:  (rv - ln(1 + rv)) / (rv)^2, 1/2 without a loss.
/// [realtime]
double stored_at_deepest(double loss_speed) noexcept;

}  // namespace tactus
