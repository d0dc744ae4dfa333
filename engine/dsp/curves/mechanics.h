#pragma once

#include <algorithm>

namespace tactus {

// The memoryless force laws of haptic rendering: Berdahl, Steiner, Oldham, "Practical hardware and algorithms
// for creating haptic musical instruments", NIME 2008, section 6.1. A force is positive in the direction of
// positive positions.

/// F = -k (x - rest)
inline double spring_force(double position_m, double stiffness_n_per_m, double rest_m) {
  return -stiffness_n_per_m * (position_m - rest_m);
}

/// F = -b v
inline double damper_force(double velocity_m_per_s, double damping_n_s_per_m) {
  return -damping_n_s_per_m * velocity_m_per_s;
}

struct Wall {
  double stiffness_n_per_m = 0;
  double damping_n_s_per_m = 0;
  double at_m = 0;

  /// Force into the wall, k (x - at) + b v, before it is kept from pulling.
  double push(double position_m, double velocity_m_per_s) const {
    return stiffness_n_per_m * (position_m - at_m) + damping_n_s_per_m * velocity_m_per_s;
  }
  bool touched(double position_m, double velocity_m_per_s) const {
    return position_m > at_m && push(position_m, velocity_m_per_s) > 0;
  }
  /// F = x > at ? -max(0, k (x - at) + b v) : 0. The damper cannot make the wall sticky.
  double force(double position_m, double velocity_m_per_s) const {
    // Worked out in any case, so that several frames can be at once.
    const double pushed = std::max(0.0, push(position_m, velocity_m_per_s));
    return position_m > at_m ? -pushed : 0.0;
  }
};

}  // namespace tactus
