#pragma once

// Thread: [any], except where a function says otherwise
#include <memory>

#include "engine/physics/solvers/network_solver.h"

namespace tactus {

/// The motion of a network itself, a step at a time: `solver = "reference"`, what the other solvers are
/// measured against, and nothing that they are made of.
///     m x'' = sum of the forces of `elements.h`,   L i' = V - R i - Bl x'
/// Forces and voltages are held over a step, driven points go in a straight line from its start to its end.
///
///  - Few points without contacts: by the exponential of the matrix of the system, exact but for rounding
///    (`exact()`).
///  - Otherwise by extrapolation of variable order and step to a local error of 1e-13, relative to the
///    largest position, velocity or current. A contact that opens or closes, a loss that begins or ends to
///    outweigh the contact's push, a friction that begins or ends to hold, a bond that slips or holds
///    again end a step of the integration at that very instant: every one integrates a smooth equation. With
///    a restitution the loss is set by the speed of each impact, at least 0.1 mm/s.
///
/// Not for real time: a step takes as long as it needs. A motion that cannot be followed leaves a state that
/// is not finite.
class ReferenceSolver final : public NetworkSolver {
 public:
  /// [control]
  explicit ReferenceSolver(const NetworkModel& model);
  ~ReferenceSolver() override;

  void start(NetworkState& state) const noexcept override;
  void store_energy(NetworkState&) const noexcept override {}
  void step(NetworkState& state) const noexcept override;
  double energy(const NetworkState& state) const noexcept override;
  double current(const NetworkState& state, int coil) const noexcept override;
  bool centred() const override { return false; }
  /// Beyond any that is stepped: nothing chooses it.
  Cost cost() const override { return {1e12, 1e12}; }

  /// Advances by the exponential of a matrix.
  bool exact() const;

 private:
  class Motion;

  const NetworkModel& model_;
  std::unique_ptr<Motion> motion_;  ///< workspace: each call fills it from the state of the network
};

}  // namespace tactus
