#pragma once

// Thread: [any]
#include <span>
#include <vector>

#include "engine/physics/couplings/couplings.h"
#include "engine/physics/solvers/link_operator.h"
#include "engine/physics/solvers/sparse_solver.h"

namespace tactus {

/// What a solver has worked out from a network when it was made: all that a program needs, beside the
/// `NetworkModel`, that makes the same steps without the engine. It refers to the solver. What a solver does
/// not have is nullptr or empty.
struct SolverTables {
  /// What the change of a driven point does to a mass: a column of A outside the masses.
  struct DrivenColumn {
    int mass, driven;
    double a;
  };
  /// What enters a group of the exact solver: a force, a wave, a voltage, or where a driven point is and how
  /// far it goes in the step (by its slot).
  enum class Entering { Force, Wave, Voltage, Place, Way };
  struct Input {
    Entering kind;
    int at;
  };
  /// Masses that are joined: q of each, k q' of each, i of each coil.
  struct Group {
    std::vector<int> masses, coils;
    std::vector<Input> inputs;
    std::vector<double> step;      ///< [Phi | G], a column for each state and each input, by columns
    std::vector<double> constant;  ///< c
    std::vector<double> unit;      ///< what 1 N on each of its masses does to its states, by columns
  };

  const Couplings* couplings = nullptr;

  // Of centred solvers.
  bool averaged = false;
  const LinkOperator* links = nullptr;
  const MassRow* row = nullptr;         ///< instead of `links` in a step, with `jumps`
  const LinkOperator* jumps = nullptr;  ///< with the constants of `links`
  const SparseSolver* solver = nullptr;
  const SparseSolver* start_solver = nullptr;  ///< with the bonds as they are at the start
  std::span<const DrivenColumn> driven = {};
  std::span<const double> start_velocity = {};  ///< as the first step sees it

  // Of the exact solver.
  std::vector<Group> groups = {};
};

}  // namespace tactus
