#pragma once

#include <vector>

#include "engine/core/units.h"
#include "engine/physics/elements.h"
#include "engine/physics/solver.h"

namespace tactus {

/// What is known of a way to step a network before it is run: counted, never timed, so it is the same on
/// every machine.
struct SolverBounds {
  Solver solver;
  int oversample;
  double multiplications = 0;  ///< a frame, while one contact touches
  bool stable = false;         ///< the linear part, and contacts up to `kHardestStrike`
  double error = 0;            ///< largest relative error of a resonance, or of the time of a contact
  /// What speaks against it.
  enum class Limit {
    None,
    CannotBeMade,  ///< too many masses or contacts for it
    TooStiff,      ///< springs or dampers make it unstable
    ShortContact,  ///< the hardest strike lasts `contact_steps`, too few to keep its energy
    Inexact,       ///< `error`
  } limit = Limit::None;
  double contact_steps = 0;
};

/// The strike that a contact has to bear: its bodies meet at this speed. [m/s]
inline constexpr double kHardestStrike = 1.0;
/// What counts as accurate: 1 %, 17 cents.
inline constexpr double kGoodEnough = 0.01;
/// Below, an explicit contact makes energy: 5 % of the speed at three steps, 1 % at five.
inline constexpr double kFewestContactSteps = 5.0;

struct SolverChoice {
  Solver solver = Solver::Passive;
  int oversample = 1;
  std::vector<SolverBounds> candidates;  ///< by multiplications
};

/// [control] The cheapest solver that is stable and accurate; with `oversample` 0, the cheapest of up to 64
/// steps a frame too. If none is accurate, the most accurate of the stable ones. The bounds, for a step of k
/// seconds:
///  - resonances: explicit and passive  (w k)^2 / 24,  implicit and averaged springs  (w k)^2 / 12,  exact 0,
///    w the highest of the network (physics: the schemes' dispersion);
///  - explicit is stable while the largest eigenvalue of M^-1 (K + 2 C / k) is below 4 / k^2 (sufficient),
///  and
///    a contact at `kHardestStrike` lasts 5 steps;
///  - contacts, with s steps in the time of a contact at that speed: explicit and exact 1.4 / s^2, passive 1
///  /
///    s^1.5, implicit 0.25 / s (measured; docs/numerics.md).
SolverChoice choose_solver(const NetworkElements& elements, Hertz rate, int oversample);

}  // namespace tactus
