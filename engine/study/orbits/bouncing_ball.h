#pragma once

// Thread: [any]
#include <vector>

#include "engine/core/matrix2.h"

namespace tactus {

/// A ball that bounces on a table which moves as A sin(theta), theta = w t. Nothing has a dimension: heights
/// are in g/w^2, speeds in g/w, times in 1/w, and the table's drive is Gamma = A w^2 / g. From bounce to
/// bounce, exactly:
///     Gamma sin(theta_n) + V_n T - T^2/2 = Gamma sin(theta_n + T)             the first T > 0
///     V_n+1 = -e (V_n - T) + (1 + e) Gamma cos(theta_n + T),   theta_n+1 = theta_n + T
/// Holmes, J. Sound Vib. 84, 1982, without its assumption that the table's own travel is small; ever smaller
/// bounces end by sticking (Luck & Mehta, Phys. Rev. E 48, 1993).
class BouncingBall {
 public:
  /// When it leaves the table and how fast; V is against the ground.
  struct Bounce {
    double phase, speed;
    bool resting = false;  ///< it lies on the table, and will for ever
  };

  /// drive > 0, 0 <= restitution < 1.
  BouncingBall(double drive, double restitution) : drive_(drive), restitution_(restitution) {}

  /// The next bounce. A ball that leaves no faster than the table sticks to it until the table falls
  /// away from under it, Gamma sin(theta) = 1.
  Bounce next(const Bounce& bounce) const;
  /// The same for a ball that flies, with d(theta', V') / d(theta, V).
  struct Linearised {
    Bounce bounce;
    Matrix2 jacobian;
  };
  Linearised next_linearised(const Bounce& bounce) const;
  /// The bounce of the orbit that hits once in `mode` periods of the table: V = mode pi,
  /// cos(theta) = mode pi (1 - e) / ((1 + e) Gamma). The drive is at least `orbit_begins`.
  Bounce orbit(int mode) const;

  /// The drives where that orbit appears and where it doubles its period: Gamma_k = k pi (1-e)/(1+e),
  /// Gamma'_k^2 = Gamma_k^2 + (2 (1 + e^2) / (1 + e)^2)^2, from trace = 1 + e^2 - (1+e)^2 Gamma sin(theta)
  /// and determinant = e^2 of the map's derivative.
  static double orbit_begins(int mode, double restitution);
  static double orbit_doubles(int mode, double restitution);

 private:
  double height(const Bounce& from, double time) const;
  double rise(const Bounce& from, double time) const;
  double next_bend(const Bounce& from, double time) const;
  double flight(const Bounce& from) const;
  Bounce land(const Bounce& from, double time) const;

  double drive_, restitution_;
};

/// The drives at which the orbit of `mode` doubles its period again and again: 1 to 2 bounces, 2 to 4,
/// ... `count` of them. Each stable orbit is followed in small steps to where a multiplier passes -1. The
/// intervals between them shrink by 4.6692 in the limit (Feigenbaum, J. Stat. Phys. 19, 1978). Fewer if one
/// is not found.
std::vector<double> period_doublings(int mode, double restitution, int count);

}  // namespace tactus
