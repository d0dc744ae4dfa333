#pragma once
// Thread: [control]

#include <algorithm>
#include <cmath>
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

// ---- its exact motion

/// A mass on a damper under a force that is held:  m x'' + b x' = F.  After t seconds
///     x+ = x + reach v + rise F,   v+ = keep v + gain F
/// with y = b t / m, keep = e^-y, reach = t phi1(y), gain = t/m phi1(y), rise = t^2/m phi2(y),
///     phi1(y) = (1 - e^-y) / y,   phi2(y) = (y - 1 + e^-y) / y^2:
/// the exact solution, however long t is. Also right without damping (y = 0) and for t = 0.
/// Source: Franklin, Powell, Workman, "Digital control of dynamic systems", 3rd ed., section 4.3.
struct HeldMass {
  double keep = 1, reach = 0, gain = 0, rise = 0;

  /// m [kg] > 0, b [N s/m] >= 0, t [s] >= 0
  static HeldMass over(double mass, double damping, double seconds) {
    const double y = damping * seconds / mass;
    return {std::exp(-y), seconds * phi1(y), seconds / mass * phi1(y), seconds * seconds / mass * phi2(y)};
  }

  static double phi1(double y) { return y < 1e-12 ? 1.0 : -std::expm1(-y) / y; }
  static double phi2(double y) {
    if (y > 0.5) return (1 - phi1(y)) / y;
    // 1/2! - y/3! + y^2/4! - ..., where the difference above would lose digits.
    double sum = 0, term = 0.5;
    for (int n = 3; n < 18; ++n) {
      sum += term;
      term *= -y / n;
    }
    return sum;
  }
};

/// A delay in whole frames and a fraction from 0 to below 1. Within a billionth of a frame it is whole.
struct SplitDelay {
  SplitDelay(Seconds delay, Hertz rate) {
    const double frames = frames_in(delay, rate);
    whole = static_cast<int>(std::floor(frames + 1e-9));
    fraction = std::max(0.0, frames - whole);
    if (fraction < 1e-9) fraction = 0;
  }

  int whole;
  double fraction;
};

// ---- borders

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
/// f T (d + f = tau_d / T; h, g, c: HeldMass). At the border a root of 1 + (K + B (1 - z^-1) / T) G = 0
/// lies on the unit circle, so K is the smallest positive number on the curve
///     -1 / G(e^jt) - B (1 - e^-jt) / T,   0 < t <= pi,
/// where it is real; all its sign changes are found on a grid of 8 points for each turn of the delay. A
/// virtual damping that is unstable by itself gives 0. Linear: no friction, no steps, no limit. Time in
/// proportion to the frames of delay.
/// Source of the method: Gryazina, Polyak, Tremba, "D-decomposition technique", Automation and Remote Control
/// 69, 2008.
WallBorder wall_border(const WallDevice& device, const WallLoop& loop);

}  // namespace tactus
