#pragma once

// Thread: [any]
#include <array>
#include <cmath>
#include <limits>
#include <memory>

// The laws of bonds, contacts and frictions.
namespace tactus {

/// A conservative force between two points that depends on their distance n = x_lower - x_upper alone [m].
/// With psi the root of the energy, energy = psi^2 / 2, psi(0) = 0 and dpsi/dn > 0, the points are pulled
/// together by
///   F(n) = psi dpsi/dn.
/// All functions are called on the audio thread.
class BondLaw {
 public:
  /// (psi(to) - psi(from)) / (to - from), and its square.
  struct Chord {
    double slope, square;
  };

  virtual ~BondLaw() = default;
  virtual double root(double n) const noexcept = 0;
  virtual double root_slope(double n) const noexcept = 0;
  /// Without loss of digits where the ends are close to each other.
  virtual Chord chord(double from, double to) const noexcept = 0;
  virtual double force(double n) const noexcept { return root(n) * root_slope(n); }
  virtual double energy(double n) const noexcept { return 0.5 * root(n) * root(n); }
  /// dF/dn [N/m]; below 0 where the force falls with the distance.
  virtual double stiffness(double n) const noexcept = 0;
  /// Largest |dF/dn| of all n [N/m].
  virtual double largest_stiffness() const noexcept = 0;
  /// Most energy that it stores while |F| <= limit [J].
  virtual double largest_energy(double limit) const noexcept = 0;
  /// |n| where |F| reaches `limit` [m].
  virtual double distance_at(double /*limit*/) const noexcept {
    return std::numeric_limits<double>::infinity();
  }
  /// psi is proportional to n.
  virtual bool linear() const noexcept { return false; }
  /// a and E of the law that `attraction` describes, for programs without the engine; else 0.
  struct Well {
    double length = 0.0, depth = 0.0;
  };
  virtual Well well() const noexcept { return {}; }
};

/// F = k n.
class LinearBond final : public BondLaw {
 public:
  explicit LinearBond(double stiffness) : stiffness_(stiffness), slope_(std::sqrt(stiffness)) {}
  double root(double n) const noexcept override { return slope_ * n; }
  double root_slope(double) const noexcept override { return slope_; }
  Chord chord(double, double) const noexcept override { return {slope_, stiffness_}; }
  double force(double n) const noexcept override { return stiffness_ * n; }
  double energy(double n) const noexcept override { return 0.5 * stiffness_ * (n * n); }
  double stiffness(double) const noexcept override { return stiffness_; }
  double largest_stiffness() const noexcept override { return stiffness_; }
  double largest_energy(double limit) const noexcept override { return 0.5 * (limit * limit) / stiffness_; }
  double distance_at(double limit) const noexcept override { return limit / stiffness_; }
  bool linear() const noexcept override { return true; }

 private:
  double stiffness_, slope_;
};

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
  double force(double n) const noexcept {
    const double slope = root_slope(n);
    return slope * slope * n * two_over_a1_;
  }
  double energy(double n) const noexcept { return 0.5 * root(n) * root(n); }
  /// dF/dn [N/m], n > 0.
  double stiffness(double n) const noexcept { return (2.0 / two_over_a1_ - 1.0) * force(n) / n; }

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

/// How the coefficient of friction falls with the speed of sliding:
///   mu(v) = kinetic + sum_i drop_i exp(-|v| / speed_i)
/// Without drops it is Coulomb's; with one, the curve of Stribeck after Tustin (IEE 94, 1947); rosin on a bow
/// takes two: 0.35 + 0.4 exp(-v / 0.01) + 0.45 exp(-v / 0.1) (Smith & Woodhouse, J. Mech. Phys. Solids 48,
/// 2000). All of them are convex, which the solver uses.
struct FrictionLaw {
  struct Drop {
    double size = 0.0;   ///< >= 0
    double speed = 1.0;  ///< [m/s], > 0
  };
  double kinetic = 0.0;  ///< mu far away from 0, >= 0
  std::array<Drop, 2> drops = {};

  /// [any] mu and its slope [s/m] at a speed >= 0.
  double coefficient(double speed) const noexcept {
    double mu = kinetic;
    for (const auto& d : drops)
      if (d.size > 0.0) mu += d.size * std::exp(-speed / d.speed);
    return mu;
  }
  double slope(double speed) const noexcept {
    double slope = 0.0;
    for (const auto& d : drops)
      if (d.size > 0.0) slope -= d.size / d.speed * std::exp(-speed / d.speed);
    return slope;
  }
  /// [any] mu(0): what holds.
  double holding() const noexcept { return kinetic + drops[0].size + drops[1].size; }
};

/// Rosin on horsehair (Smith & Woodhouse).
inline constexpr FrictionLaw kRosin{0.35, {{{0.4, 0.01}, {0.45, 0.1}}}};

}  // namespace tactus
