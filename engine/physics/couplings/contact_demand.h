#pragma once

// Thread: [control]
#include <vector>

#include "engine/physics/elements.h"

namespace tactus {

/// The strike that a contact has to bear: its bodies meet at this speed. [m/s]
inline constexpr double kHardestStrike = 1.0;

/// Bounds on the contacts and bonds of a network, from its start values. A contact stiffens with depth.
///
///  - **How short it is**, with alpha the exponent and m the reduced mass of its two bodies, at the speed v
///    that they may have by themselves: `kHardestStrike`, or what the start gives them,
///    v^2 = v_start^2 + 2 phi(n_start) / m:
///      t = 2 sqrt(pi) Gamma(1 + 1/(alpha+1)) / Gamma(1/2 + 1/(alpha+1)) ((alpha+1) m v^2 / 2K)^(1/(alpha+1))
///      / v
///  - **How stiff it gets**: no contact is deeper than where it holds all the energy E that the network
///    starts with, together with that of a strike of the heaviest body, phi(n) = E; there it is a spring and
///    a damper
///      k = alpha K n^(alpha-1),   z = r K n^alpha.
///    Of two contacts that act in opposite ways between the same points only one is ever closed.
struct ContactDemand {
  struct Strike {
    double exponent, time_s;
  };
  std::vector<Strike> strikes;  ///< for each exponent the shortest
  double stiffness = 0.0;       ///< bounds the largest eigenvalue of M^-1 K of all k together [1/s^2]
  double damping = 0.0;         ///< the same of all z [1/s]
};

/// [control]
ContactDemand contact_demand(const NetworkElements& elements);

}  // namespace tactus
