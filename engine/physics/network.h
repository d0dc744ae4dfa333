#pragma once

// Thread: [any], except where a function says otherwise
#include <functional>
#include <memory>
#include <vector>

#include "engine/core/error.h"
#include "engine/core/units.h"
#include "engine/physics/parts.h"
#include "engine/physics/solvers/network_solver.h"
#include "engine/physics/solvers/solver_choice.h"

namespace tactus {

/// What the numbers of a `NetworkState` belong to: of each, which one it is in the network as it is written.
/// A network that is made anew, and from which other parts were left out, finds its state by these. Rising.
struct StateOrigins {
  std::vector<int> moving;  ///< slots of masses, then of driven points
  std::vector<int> contacts, bonds, frictions, coils, forces, ports;
  std::vector<int> signals;
  std::vector<int> low_passes;
};

/// Masses on a line, joined by springs, contacts, frictions, bonds and coils, stepped at a fixed rate 1/k =
/// rate * oversample.
///
/// Forces, voltages and waves of frame n are held until frame n + 1. Driven points go in a straight line to
/// the position of frame n until frame n + 1. On the first frame they, and hands, are there already. Outputs
/// at frame n depend on inputs before frame n only.
class Network {
 public:
  /// [control] `signals` inputs are handed to each step. rate > 0; 1 <= oversample <= 64, or 0: as many as
  /// `Solver::Auto` finds right (1 for the others). The numbers of the elements are in their ranges and their
  /// points exist (asserted: the graph file was checked before). Errors: those of the solver.
  static Result<Network> make(const NetworkElements& elements, int signals, Hertz rate, Solver solver,
                              int oversample);
  /// [control] The same, stepped by what `make_solver` makes: for studies of other methods. Outputs are read
  /// as those of the reference.
  using MakeSolver = std::function<std::unique_ptr<NetworkSolver>(const NetworkModel&)>;
  static Network make(const NetworkElements& elements, int signals, Hertz rate, int oversample,
                      const MakeSolver& make_solver);

  /// [control] Allocates; at the start of the network.
  NetworkState initial_state() const;
  /// [realtime] Back to the start.
  void reset(NetworkState& state) const noexcept;
  /// [control] `parts`: which part of the network as it is written each part is; `signals`: each input.
  StateOrigins origins(const PartNumbers& parts, const std::vector<int>& signals) const;
  /// A network with its state, for `adopt`.
  struct Before {
    const Network& network;
    const NetworkState& state;
    const StateOrigins& origins;
  };
  /// [realtime] Goes on from the state of a network of the same elements with other numbers, solver or parts
  /// that were left out: positions and motions stay, what contacts store follows from the indentation (energy
  /// changes with the stiffness, nothing jumps). Parts that were not there before are where they start; fixed
  /// points are where they are now.
  void adopt(NetworkState& state, const StateOrigins& origins, const Before& before) const noexcept;
  /// [realtime] From frame n to n + 1 with the inputs of frame n.
  void step(NetworkState& state, const double* inputs) const noexcept;

  /// [realtime] Of a point, in the order of the elements.
  double position(const NetworkState& state, int point) const noexcept {
    return state.position[index(model_->slot[index(point)])];
  }
  double velocity(const NetworkState& state, int point) const noexcept {
    return network_solver_->velocity(state, model_->slot[index(point)]);
  }
  double extension(const NetworkState& state, int spring) const noexcept {
    return tactus::extension(state.position, model_->springs[index(spring)]);
  }
  /// Tension.
  double spring_force(const NetworkState& state, int spring) const noexcept;
  /// Never below 0.
  double indentation(const NetworkState& state, int contact) const noexcept;
  double contact_force(const NetworkState& state, int contact) const noexcept;
  double applied_force(const NetworkState& state, int force) const noexcept;
  double current(const NetworkState& state, int coil) const noexcept {
    return network_solver_->current(state, coil);
  }
  double coil_force(const NetworkState& state, int coil) const noexcept {
    return model_->coils[index(coil)].force_factor * current(state, coil);
  }
  /// Of the last step.
  double friction_force(const NetworkState& state, int friction) const noexcept {
    return state.friction_force[index(friction)];
  }
  double friction_velocity(const NetworkState& state, int friction) const noexcept {
    return state.friction_velocity[index(friction)];
  }
  double bond_force(const NetworkState& state, int bond) const noexcept;
  /// x_lower - x_upper; with several axes how much longer it is than at rest.
  double bond_distance(const NetworkState& state, int bond) const noexcept {
    return stretch(state.position, model_->bonds[index(bond)]);
  }
  /// What goes out of a port, a - Z v, mean of the last frame; and the force a + b on the mass with it.
  double wave(const NetworkState& state, int port) const noexcept { return state.wave_back[index(port)]; }
  double port_force(const NetworkState& state, int port) const noexcept {
    return state.wave[index(port)] + state.wave_back[index(port)];
  }
  /// Stored in masses, springs, contacts, bonds and inductances (centred solvers: half a step before the
  /// frame).
  double energy(const NetworkState& state) const noexcept { return network_solver_->energy(state); }

  /// [any]
  bool springs_averaged() const { return network_solver_->springs_averaged(); }
  Solver solver() const { return choice_.solver; }
  int oversample() const { return choice_.oversample; }
  /// [any] The same, with what there was to choose from where `Auto` chose.
  const SolverChoice& choice() const { return choice_; }
  const NetworkSolver& network_solver() const { return *network_solver_; }
  const NetworkModel& model() const { return *model_; }

 private:
  Network() = default;
  void adopt_motion(NetworkState& state, int slot, const Before& before, int from) const noexcept;
  void settle(NetworkState& state, const double* inputs) const noexcept;
  void settle_low_pass(NetworkState& state, const NetworkInput& input, const double* inputs) const noexcept;
  void substep(NetworkState& state, const double* inputs, int part) const noexcept;
  double enter(NetworkState& state, const NetworkInput& input, const double* inputs, int part) const noexcept;
  void move_driven(NetworkState& state, const double* inputs, int part) const noexcept;
  void press(NetworkState& state, const double* inputs, int part) const noexcept;
  double speed_between(const NetworkState& state, int one, int other) const noexcept {
    return network_solver_->velocity(state, one) - network_solver_->velocity(state, other);
  }

  SolverChoice choice_;
  // The solver refers to the model.
  std::shared_ptr<const NetworkModel> model_;
  std::shared_ptr<const NetworkSolver> network_solver_;
};

}  // namespace tactus
