#pragma once
// Thread: [control]

#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "engine/physics/solvers/network_solver.h"

namespace tactus {

/// A published method that the solvers of networks are compared with, as its paper has it: it integrates the
/// same equations of motion, M x'' = F(x, x', inputs), with the same held inputs. For studies only: it
/// allocates while it runs.
struct PublishedMethod {
  const char* name;    ///< "verlet"
  const char* title;   ///< "Störmer–Verlet"
  const char* source;  ///< where it was published
  /// Its multiplications are counted while it runs: `NetworkSolver::cost` is their mean per step.
  std::unique_ptr<NetworkSolver> (*make)(const NetworkModel&);
};

/// All of them.
///
///  - verlet: velocity Verlet; velocities at the end of a step are predicted where forces depend on them.
///  - newmark: average acceleration (beta = 1/4, gamma = 1/2), Newton's method.
///  - sav: scalar auxiliary variable: as verlet in the linear part, all contacts by one quadratised energy,
///    in one division; their loss is explicit.
///  - gauss: Gauss-Legendre with two stages, of order four, Newton's method.
const std::array<PublishedMethod, 4>& published_methods();
/// nullptr if there is none of that name.
const PublishedMethod* find_method(std::string_view name);

/// Why none of them steps a network with these elements: laws with a set of forces at rest, or with jumps,
/// need a method of their own. Empty: they do.
std::string why_not_applicable(const NetworkElements& elements);

}  // namespace tactus
