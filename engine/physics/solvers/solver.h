#pragma once

// Thread: [any]
namespace tactus {

/// How a network is stepped; each is described with its class.
enum class Solver {
  Explicit,   ///< the cheapest for many masses; unstable when too stiff (CentredSolver)
  Passive,    ///< never makes energy, whatever the stiffness (CentredSolver)
  Implicit,   ///< the trapezoidal rule and Newton's method: never unstable (CentredSolver)
  Exact,      ///< no error in the linear part; small groups of masses (ExactSolver)
  Reference,  ///< the motion itself, which the others are measured against (ReferenceSolver)
  Auto,       ///< the cheapest of them that is stable and accurate (solver_choice.h)
};

}  // namespace tactus
