#pragma once

// Thread: [any]
#include <array>
#include <cmath>

namespace tactus {

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

/// A force of friction and the velocity that goes with it.
struct FrictionForce {
  double force = 0.0;     ///< [N], against the velocity
  double velocity = 0.0;  ///< of sliding [m/s]; 0: it holds
};

/// [realtime] The friction of two bodies that without it would slide at `free` [m/s] and which a force slows
/// by `mobility` [m/s/N]:
///   v + mobility F = free,   F = normal mu(|v|) sgn v + viscous v,   or v = 0 with |F| <= normal mu(0).
/// Where both holding and sliding would do, what was so before stays so (`sliding`: the sign of the velocity
/// before, 0 if it held): McIntyre, Schumacher & Woodhouse, JASA 74, 1983. Of two ways of sliding it is the
/// faster, the stable one. A step's mean velocity of 0 would turn a body that comes in with one back again:
/// where that takes no energy from the friction, it is stopped on half its way, at the mean `stopping`.
FrictionForce solve_friction(const FrictionLaw& law, double viscous, double normal, double free,
                             double mobility, int sliding, double stopping = 0.0) noexcept;

}  // namespace tactus
