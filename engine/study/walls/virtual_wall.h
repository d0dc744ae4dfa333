#pragma once
// Thread: [control]

#include <limits>

#include "engine/core/units.h"

namespace tactus {

/// What a virtual wall pushes: a mass on a damper,  m x'' + b x' = F,  with its imperfections.
struct WallDevice {
  double mass = 0.05;    ///< m [kg] > 0, as felt where the position is measured
  double damping = 0.1;  ///< b [N s/m] >= 0, of the device and of the hand on it
  double friction = 0;   ///< f_c [N] >= 0, dry: opposes motion at any speed with the same force
  double quantum = 0;    ///< Delta [m] >= 0, of the position sensor; 0: none
  double force_limit = std::numeric_limits<double>::infinity();  ///< F_max [N] of the motor

  /// The device in a hand: masses and dampers add up.
  WallDevice held(double hand_mass, double hand_damping) const {
    auto device = *this;
    device.mass += hand_mass;
    device.damping += hand_damping;
    return device;
  }
};

/// The controller: sampled every T, the force held in between and `delay` late.
///     F[n] = -(K x[n] + B (x[n] - x[n-1]) / T)
struct WallLoop {
  Hertz rate = 20_kHz;
  Seconds delay = {};  ///< tau_d >= 0, sensor to actuator, whole frames or not
  double damping = 0;  ///< B [N s/m], virtual

  double period() const { return 1 / rate.value; }
  /// tau = tau_d + T/2 [s]: a held value is half a frame old on average.
  double lag() const { return delay.value + 0.5 * period(); }
};

// The stiffest wall, K [N/m], by formulas. `wall_border` gives the exact one.

/// K < (b + B) / (T/2 + tau_d): a loop much faster than the device, (b + B) (T/2 + tau_d) / m << 1; at 0.005
/// it is right within 1 %. Damping of the wall's own counts like the device's.
/// Gil, Sanchez, Hulin, Preusche, Hirzinger, J. Computing and Information Science in Engineering 9, 2009;
/// Hulin, Albu-Schaffer, Hirzinger, IEEE Trans. Control Systems Technology 22, 2014.
double stiffest_by_damping(const WallDevice& device, const WallLoop& loop);

/// K <= (b - |B|) / (T/2 + tau_d): passive, so stable in any hand that is so itself. Virtual damping only
/// costs. Exact for B = 0, since Re{(1 - e^-jwT) e^-jwtau_d} / (1 - cos wT) is a Dirichlet kernel, largest at
/// w = 0; enough otherwise. Without delay b > K T / 2 + |B|: Colgate & Schenkel, J. Robotic Systems 14, 1997.
/// 0 where |B| >= b.
double stiffest_passive(const WallDevice& device, const WallLoop& loop);

/// K <= 2 f_c / Delta: dry friction dissipates the energy that a step of the encoder adds; infinite without
/// steps. With K <= 2 b / T it makes a wall passive: Abbott & Okamura, IEEE Trans. Robotics 21, 2005. At or
/// above f_c = K Delta / 2 no limit cycle starts at the encoder's edge: Diolaiti, Niemeyer, Barbagli,
/// Salisbury, IEEE Trans. Robotics 22, 2006.
double stiffest_by_friction(const WallDevice& device);

/// Largest stable stiffness of a wall.
struct WallBorder {
  double stiffness = 0;  ///< [N/m]; 0: no wall at all is stable
  Hertz frequency = {};  ///< of the oscillation at that stiffness
};

/// The stiffest stable wall, exactly: device and hold in the z-domain,
///     G(z) = z^-d ((z - p) (h1 z^-1 + h2) + c (g1 z^-1 + g2)) / ((z - 1) (z - p)),   p = e^(-b T / m),
/// where the force of d frames ago acts for the last (1 - f) T of a frame and the one before it for the first
/// f T (d + f = tau_d / T; h, g, c: held_mass.h). At the border a root of 1 + (K + B (1 - z^-1) / T) G = 0
/// lies on the unit circle, so K is the smallest positive number on the curve
///     -1 / G(e^jt) - B (1 - e^-jt) / T,   0 < t <= pi,
/// where it is real; all its sign changes are found on a grid of 8 points for each turn of the delay. A
/// virtual damping that is unstable by itself gives 0. Linear: no friction, no steps, no limit. Time in
/// proportion to the frames of delay.
/// Source of the method: Gryazina, Polyak, Tremba, "D-decomposition technique", Automation and Remote Control
/// 69, 2008.
WallBorder wall_border(const WallDevice& device, const WallLoop& loop);

}  // namespace tactus
