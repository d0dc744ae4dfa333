#pragma once

// Thread: [control]
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "engine/core/units.h"
#include "engine/physics/couplings/force_laws.h"

namespace tactus {

/// A signal that enters a network, by its place in the inputs of `Network::step`; -1: always 0.
/// With a bandwidth (-3 dB) it goes through two equal real poles first: what a muscle does to an intention.
struct NetworkInput {
  int signal = -1;
  std::optional<Hertz> bandwidth;
  int low_pass = -1;  ///< where there is a bandwidth: which of `NetworkModel::low_passes`
};

/// A point on the axis of the network; up is positive. [m], [m/s], [kg]
struct Point {
  enum class Kind {
    Mass,    ///< moved by the forces on it
    Ground,  ///< stays at `position`
    Motion,  ///< goes where `input` says: in a straight line from sample to sample, one frame later
  };
  Kind kind = Kind::Mass;
  double mass = 0.0;
  double position = 0.0;  ///< at the start
  double velocity = 0.0;  ///< at the start (masses)
  NetworkInput input;
};

/// Where a body moves along several axes, each axis is a point of its own with the same mass; these points
/// follow each other in the list, and links name the first.
inline constexpr int kMostAxes = 3;

/// Tension T = k e + z e',  e = x_upper - x_lower - rest;  pulls `lower` up and `upper` down.
/// Between bodies of several axes along a fixed direction n, small displacements:
///   e = n . (x_upper - x_lower) - rest,  force T n on `lower`.
struct Spring {
  int lower = 0, upper = 0;
  /// k [N/m]; below 0 only where the springs of an element together are not (see `add_bending`).
  double stiffness = 0.0;
  double damping = 0.0;  ///< z [N s/m], >= 0
  double rest = 0.0;     ///< [m]
  int axes = 1;
  std::array<double, kMostAxes> along = {1.0, 0.0, 0.0};  ///< n, a unit vector
};

/// Push F = K n^a (1 + r n') where n = x_lower - x_upper + offset > 0, never below 0; pushes `lower` down and
/// `upper` up. Hunt & Crossley, J. Appl. Mech. 42, 1975.
/// With `restitution` e the loss r is set anew at each impact, so that the ratio of the speeds does not
/// depend on the speed: r v is then a number that depends on e alone (see `loss_for_restitution`).
struct Contact {
  int lower = 0, upper = 0;
  double stiffness = 0.0;             ///< K [N/m^a], > 0
  double exponent = 1.5;              ///< a, 1 ... 10
  double loss = 0.0;                  ///< r [s/m], >= 0
  std::optional<double> restitution;  ///< e, 0.01 ... 1
  double offset = 0.0;                ///< [m]
};

/// A force on a mass [N], held from frame to frame.
struct AppliedForce {
  int on = 0;
  NetworkInput input;
};

/// A coil on a point in the field of a magnet on another:  L i' = V - R i - Bl (x_on - x_against)',
/// F = Bl i on `on`, -F on `against`.
struct Coil {
  int on = 0;
  int against = -1;           ///< -1: fixed
  double force_factor = 0.0;  ///< Bl [T m]
  double resistance = 0.0;    ///< R [ohm], > 0
  double inductance = 0.0;    ///< L [H], >= 0
  NetworkInput voltage;       ///< V [V], held from frame to frame
};

/// Friction  F = N mu(|v|) sgn v + c v  against the sliding v = x_lower' - x_upper'; pushes `lower` down and
/// `upper` up where v > 0. At v = 0 it holds with up to N mu(0). What N is: `normal` [N], or the push of a
/// contact or the tension of a spring of the same network; below 0 it counts as 0.
struct Friction {
  int lower = 0, upper = 0;
  FrictionLaw law;
  double viscous = 0.0;  ///< c [N s/m], >= 0
  NetworkInput normal;
  int normal_contact = -1;  ///< instead of `normal`
  int normal_spring = -1;   ///< instead of `normal`
};

/// A conservative force by any law and a damper between two points, n = x_lower - x_upper:
///   F = law(n) + z n';  pushes `lower` down and `upper` up where F > 0.
/// The points slip off each other when |law(n)| exceeds `limit`, and hold again when they have come back past
/// each other.
/// Between bodies of several axes the force acts along the line between them, wherever they are:
///   n = |r| - rest,  r = x_lower - x_upper;  F r / |r| pulls the bodies together.
struct Bond {
  int lower = 0, upper = 0;
  std::shared_ptr<const BondLaw> law;
  double damping = 0.0;                                    ///< z [N s/m], >= 0
  double limit = std::numeric_limits<double>::infinity();  ///< [N], > 0; infinite with several axes
  int axes = 1;
  double rest = 0.0;  ///< with several axes: length at zero force [m]

  bool slips() const { return std::isfinite(limit); }
};

/// Where a wave of force travels between a mass and something outside, as in a string of impedance Z:
///   F = 2 a - Z v,   b = a - Z v
/// with a what comes in, b what goes out again, v the velocity of the mass. The power into the mass is
/// F v = (a^2 - b^2) / Z, so two ports of one impedance may be joined by any delay and stay passive.
/// J. O. Smith, Physical Audio Signal Processing, W3K, 2010.
struct WavePort {
  int on = 0;
  double impedance = 0.0;  ///< Z [N s/m], > 0
  NetworkInput wave;       ///< a [N], held from frame to frame
};

/// All that a network is made of. Links name points by their index.
struct NetworkElements {
  std::vector<Point> points;
  std::vector<Spring> springs;
  std::vector<Contact> contacts;
  std::vector<AppliedForce> forces;
  std::vector<Coil> coils;
  std::vector<Friction> frictions;
  std::vector<Bond> bonds;
  std::vector<WavePort> ports;
};

}  // namespace tactus
