#pragma once

// Thread: [any]
#include <cmath>
#include <limits>
#include <memory>
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

}  // namespace tactus
