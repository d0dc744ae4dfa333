#pragma once

// Thread: [any], except where a function says otherwise
#include <memory>

#include "engine/physics/reference/reference_integrator.h"
#include "engine/physics/solvers/network_solver.h"

namespace tactus {

/// Not a step but the motion itself (ReferenceIntegrator), a step at a time: `solver = "reference"`, which
/// the others are measured against. Not for real time: a step takes as long as it needs.
class ReferenceSolver final : public NetworkSolver {
 public:
  /// [control] `elements` are those that the model was made of.
  ReferenceSolver(const NetworkModel& model, const NetworkElements& elements);

  void start(NetworkState& state) const noexcept override;
  void store_energy(NetworkState&) const noexcept override {}
  void step(NetworkState& state) const noexcept override;
  double energy(const NetworkState& state) const noexcept override;
  double velocity(const NetworkState& state, int slot) const noexcept override;
  double current(const NetworkState& state, int coil) const noexcept override;
  bool centred() const override { return false; }
  /// Beyond any that is stepped: nothing chooses it.
  Cost cost() const override { return {1e12, 1e12}; }

 private:
  void load(const NetworkState& state) const noexcept;
  void keep(NetworkState& state) const noexcept;

  const NetworkModel& model_;
  ReferenceIntegrator flow_;  // its points are the slots of the model
  // Workspace: each call fills it from the state of the network.
  mutable ReferenceIntegrator::State now_;
};

}  // namespace tactus
