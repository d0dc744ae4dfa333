#pragma once

// Thread: [control]
#include <vector>

#include "engine/core/units.h"
#include "engine/physics/elements.h"
#include "engine/physics/solvers/network_solver.h"

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

/// Bounds on a solver for a network, from operation counts and never from a clock, so it is the same on
/// every machine.
struct SolverBounds {
  Solver solver;
  int oversample;
  double multiplications = 0;  ///< a frame, with one closed contact
  bool stable = false;         ///< the linear part, and contacts as far as `ContactDemand` goes
  double error = 0;            ///< largest relative error of a resonance, or of the time of a contact
  /// What speaks against it.
  enum class Limit {
    None,
    CannotBeMade,  ///< too many masses or contacts for it
    TooStiff,      ///< springs or dampers make it unstable
    ShortContact,  ///< the hardest strike lasts `contact_steps`, too few to keep its energy
    DeepContact,   ///< what the network starts with, or the hardest strike, can press one too stiff
    Inexact,       ///< `error`
  } limit = Limit::None;
  double contact_steps = 0;
};

/// What counts as accurate: 1 %, 17 cents.
inline constexpr double kGoodEnough = 0.01;
/// Below, an explicit contact makes energy: 5 % of the speed at three steps, 1 % at five.
inline constexpr double kFewestContactSteps = 5.0;
/// Above, too: k^2 times the stiffness of a pressed contact over its mass; 1 % of the speed for a cubic law
/// at five steps, 2 % for the tenth power at thirteen.
inline constexpr double kStiffestContact = 1.6;

/// Steps a frame that are tried.
inline constexpr int kMostOversample = 64;

struct SolverChoice {
  Solver solver = Solver::Passive;
  int oversample = 1;
  std::vector<SolverBounds> candidates;  ///< by multiplications
};

/// [control] The cheapest solver that is stable and accurate; with `oversample` 0, the cheapest of up to 64
/// steps a frame too. If none is accurate, the most accurate of the stable ones. The bounds, for a step of k
/// seconds:
///  - resonances: explicit and passive  (w k)^2 / 24,  implicit and averaged springs  (w k)^2 / 12,  exact 0,
///    w the highest of the network (physics: the solvers' dispersion);
///  - explicit is stable while k^2 times the largest eigenvalue of M^-1 (K + 2 C / k) is below 4, contacts
///    and bonds as deep as in `ContactDemand` among them (sufficient), these alone are below
///    `kStiffestContact`, and the shortest contact lasts 5 steps;
///  - contacts, with s steps in the time of one of exponent a: exact (0.5 + 0.33 a) / s^2, explicit the same
///    but at least 1.4 / s^2, passive max(1, 0.12 a) / s^1.5, implicit (1.3 + 0.86 a) / s^2: the largest of
///    40 phases, measured for a = 1 ... 10 and s = 3 ... 20.
SolverChoice choose_solver(const NetworkElements& elements, Hertz rate, int oversample);

}  // namespace tactus
