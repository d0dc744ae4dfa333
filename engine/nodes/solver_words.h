#pragma once

#include <array>
#include <string>

#include "engine/physics/solver_choice.h"

namespace tactus {

/// [any] All that a file may name, in the order of their cost.
inline constexpr std::array kSolvers = {Solver::Explicit, Solver::Exact,     Solver::Implicit,
                                        Solver::Passive,  Solver::Reference, Solver::Auto};

/// [any] The word in a file.
const char* name_of(Solver solver);

/// [any] Which solver was taken and why none of the cheaper ones: one sentence.
std::string reason_for(const SolverChoice& choice);

}  // namespace tactus
