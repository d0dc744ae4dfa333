#pragma once

#include <vector>

#include "engine/study/orbits/bouncing_ball.h"

namespace tactus {

/// An orbit that closes after some bounces.
struct ClosedOrbit {
  BouncingBall::Bounce bounce;
  Matrix2 jacobian;  ///< of all its bounces together
  bool found = false;

  /// Falls through 0 where the orbit doubles its period: det(J + 1), zero for a multiplier of -1.
  double before_doubling() const;
  /// Both multipliers lie within the unit circle.
  bool stable() const;
};

/// [any] By Newton's method from near it: the orbit that closes after `bounces` bounces and `mode * bounces`
/// periods of the table.
ClosedOrbit close_orbit(const BouncingBall& ball, int mode, int bounces, const BouncingBall::Bounce& near);

/// [any] The drives at which the orbit of `mode` doubles its period again and again: 1 to 2 bounces, 2 to 4,
/// ... `count` of them. Each stable orbit is followed in small steps to where a multiplier passes -1. The
/// intervals between them shrink by 4.6692 in the limit (Feigenbaum, J. Stat. Phys. 19, 1978). Fewer if one
/// is not found.
std::vector<double> period_doublings(int mode, double restitution, int count);

}  // namespace tactus
