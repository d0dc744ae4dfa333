#pragma once

// Thread: [control]
#include <array>
#include <string>

#include "engine/graph/file/field.h"
#include "engine/physics/solvers/solver_choice.h"

namespace tactus {

/// [any] All that a file may name, those to play with first.
inline constexpr std::array kSolvers = {Solver::Explicit, Solver::Exact, Solver::Implicit,
                                        Solver::Passive,  Solver::Auto,  Solver::Reference};

/// [any] The name in a file.
const char* name_of(Solver solver);
/// [any] Where it comes from.
const char* source_of(Solver solver);

/// [any] The keys of `[networks.x]` beside its elements.
const SectionType& network_options();

/// [any] "error at most 0.4 %", or why the error is not bounded.
std::string describe_bound(const SolverBounds& bounds);

/// [any] Which solver was taken, a warning if even that one is not accurate, and why none of the cheaper
/// ones: a line for each solver at most.
std::string explain_choice(const SolverChoice& choice);

}  // namespace tactus
