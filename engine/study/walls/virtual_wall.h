#pragma once

#include <limits>
#include <optional>

#include "engine/core/units.h"

namespace tactus {

/// What a virtual wall pushes: a mass on a damper,  m x'' + b x' = F,  with the faults that matter.
struct WallDevice {
  double mass = 0.05;    ///< m [kg] > 0, as felt where the position is measured
  double damping = 0.1;  ///< b [N s/m] >= 0, of the device and of the hand on it
  double friction = 0;   ///< f_c [N] >= 0, dry: opposes motion at any speed with the same force
  double quantum = 0;    ///< Delta [m] >= 0, of the position sensor; 0: none
  double force_limit = std::numeric_limits<double>::infinity();  ///< F_max [N] of the motor
};

/// Who renders it: sampled every T, the force held in between and `delay` late.
///     F[n] = -(K x[n] + B (x[n] - x[n-1]) / T)
struct WallLoop {
  Hertz rate = 20_kHz;
  Seconds delay = {};  ///< tau_d >= 0, sensor to actuator, whole frames or not
  double damping = 0;  ///< B [N s/m], virtual

  double period() const { return 1 / rate.value; }
  /// tau = tau_d + T/2 [s]: a held value is half a frame old on average.
  double lag() const { return delay.value + 0.5 * period(); }
};

// The stiffest wall, K [N/m], by formulas. The exact one is in wall_border.h.

/// K < (b + B) / (T/2 + tau_d): a loop much faster than the device, (b + B) (T/2 + tau_d) / m << 1; at 0.005
/// it is right within 1 %. Damping of the wall's own counts like the device's.
/// Gil, Sanchez, Hulin, Preusche, Hirzinger, J. Computing and Information Science in Engineering 9, 2009;
/// Hulin, Albu-Schaffer, Hirzinger, IEEE Trans. Control Systems Technology 22, 2014.
double stiffest_by_damping(const WallDevice& device, const WallLoop& loop);

/// K = (b / tau) phi / sin phi with phi tan phi = b tau / m: a device in continuous time behind a delay tau
/// [s], B = 0, for any b tau / m; the factor grows from 1 to pi/2. Right where T << tau. From the root
/// s = j phi / tau of m s^2 + b s + K e^(-s tau).
double stiffest_behind_delay(const WallDevice& device, Seconds lag);

/// K = b (1 - p) / ((1 - p) m / b - p T), p = e^(-b T / m): sampled and held without any other delay, B = 0;
/// exact. Near 2 b / T for b T / m << 1. From the product of the two roots, which is 1 at the border.
double stiffest_undelayed(const WallDevice& device, Hertz rate);

/// K <= (b - |B|) / (T/2 + tau_d): passive, so stable in any hand that is so itself. Virtual damping only
/// costs. Exact for B = 0, since Re{(1 - e^-jwT) e^-jwtau_d} / (1 - cos wT) is a Dirichlet kernel, largest at
/// w = 0; enough otherwise. Without delay b > K T / 2 + |B|: Colgate & Schenkel, J. Robotic Systems 14, 1997.
/// 0 where |B| >= b.
double stiffest_passive(const WallDevice& device, const WallLoop& loop);

/// K <= 2 f_c / Delta: dry friction eats what a step of the encoder gives; infinite without steps. With K <=
/// 2 b / T it makes a wall passive: Abbott & Okamura, IEEE Trans. Robotics 21, 2005. At or above f_c = K
/// Delta / 2 no limit cycle starts at the encoder's edge: Diolaiti, Niemeyer, Barbagli, Salisbury, IEEE
/// Trans. Robotics 22, 2006.
double stiffest_by_friction(const WallDevice& device);

/// What goes on for ever around one edge of the encoder.
struct EdgeCycle {
  Hertz frequency;
  double counts;  ///< amplitude over Delta
};
/// A hand leans on the wall with half of K Delta, so that the force jumps between +M and -M, M = K Delta / 2,
/// each tau = T/2 + tau_d after the device crosses the edge: a relay behind a delay on 1 / (s (m s + b)).
/// With a = b/m, from one jump to the next (h = half a period)
///     v0 = -(M/b) tanh(a h / 2),   x0 = -((M/b) h + (v0 - M/b) (1 - e^-ah) / a) / 2,
///     x(t) = x0 + (M/b) t + (v0 - M/b) (1 - e^-at) / a,   x(h - tau) = 0.
/// Exact for T << tau and the passage over one edge only, counts < 1/2. Nothing where f_c >= M. Needs b > 0
/// and Delta > 0. Tsypkin, "Relay control systems", 1984, chapter 4.
std::optional<EdgeCycle> encoder_edge_cycle(const WallDevice& device, double stiffness, Seconds lag);

/// Speed after a bounce over the speed before, of a device without damping:
///     e = exp((pi w tau / 2) / sqrt(1 - (w tau / 2)^2)),  w = sqrt(K/m), tau = T/2 + tau_d.
/// The delay acts as a damper of -K tau. Within 1 % for w tau <= 0.2; needs w tau < 2.
double wall_rebound(double mass, double stiffness, Seconds lag);

/// Amplitude [m] at which a spring above its border comes to rest in a limit cycle, its force cut at F_max:
/// where the describing function of the cut, with r = amplitude K / F_max,
///     K (2/pi) (asin(1/r) + sqrt(1 - 1/r^2) / r) = K_border.
/// Needs 0 < border < stiffness and a finite limit. Too small by what it leaves out of the harmonics: 1 %
/// just above the border, 12 % far above it, where the force is a square wave (encoder_edge_cycle with M =
/// F_max is exact there). Gelb & Vander Velde, "Multiple-input describing functions", 1968, section 2.3.
double cut_cycle_amplitude(double stiffness, double border, double force_limit);

}  // namespace tactus
