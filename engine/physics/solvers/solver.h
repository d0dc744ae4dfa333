#pragma once

namespace tactus {

/// How a network is stepped; what each of them is stands with its scheme.
enum class Solver {
  Explicit,   ///< the cheapest for many masses; unstable when too stiff (CentredScheme)
  Passive,    ///< never makes energy, whatever the stiffness (CentredScheme)
  Implicit,   ///< the trapezoidal rule and Newton's method: never unstable (CentredScheme)
  Exact,      ///< no error in the linear part; small groups of masses (ExactScheme)
  Reference,  ///< the motion itself, which the others are measured against (FlowScheme)
  Auto,       ///< the cheapest of them that is stable and accurate (solver_choice.h)
};

}  // namespace tactus
