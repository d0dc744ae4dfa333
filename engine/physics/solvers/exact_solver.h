#pragma once

// Thread: [any], except where a function says otherwise
#include <Eigen/Core>
#include <memory>
#include <vector>

#include "engine/core/error.h"
#include "engine/physics/couplings/couplings.h"
#include "engine/physics/solvers/network_solver.h"

namespace tactus {

/// Steps the linear part exactly. For each group of masses that springs, dampers and coils join, with x =
/// (positions, velocities, currents),
///     x+ = Phi x + G f + c,    [Phi G; 0 1] = exp(k [A B; 0 0]),
/// f being what enters (forces, voltages, waves: held for the step; driven points: along straight lines). No
/// error at the frames, whatever the stiffness (Van Loan, IEEE Trans. Autom. Control 23, 1978). A group of n
/// masses costs (2n)^2 multiplications a step.
///
/// Couplings push with one force for the whole step. A held force F that moves its points by d does the work
/// F d exactly, so with quadratised energy over one step, F = g (psi + psi+)/2 and psi+ = psi + g d, all
/// energy is kept to rounding here too.
class ExactSolver final : public NetworkSolver {
 public:
  /// Masses and coils of one group: beyond, the other solvers are cheaper by far.
  static constexpr int kMostStates = 256;

  /// [control] Errors: OutOfRange if a group is too large, or its numbers too far apart.
  static Result<std::unique_ptr<NetworkSolver>> make(const NetworkModel& model);

  void start(NetworkState& state) const noexcept override;
  void store_energy(NetworkState& state) const noexcept override;
  void step(NetworkState& state) const noexcept override;
  double energy(const NetworkState& state) const noexcept override;
  double velocity(const NetworkState& state, int slot) const noexcept override;
  double current(const NetworkState& state, int coil) const noexcept override;
  bool centred() const override { return false; }
  Cost cost() const override;

 private:
  using Matrix = Eigen::MatrixXd;

  /// Masses that are joined, and what they hold: q of each, k q' of each, i of each coil with an inductance.
  struct Group {
    std::vector<int> masses, coils;
    int states() const { return static_cast<int>(2 * masses.size() + coils.size()); }
  };
  /// A column of a block's matrix: something that enters, or how far a driven point goes in the step.
  struct Input {
    enum class From { Force, Voltage, Wave, Place, Way } from;
    int source;
  };
  struct Block {
    Group group;
    std::vector<Input> inputs;
    Matrix step;               ///< [Phi | G], a column for each state and each input
    Eigen::VectorXd constant;  ///< c
    Matrix unit;               ///< what a force of 1 N on each of its masses does to its states
    int first = 0;             ///< in `NetworkState::flow`
  };
  struct Rates;

  explicit ExactSolver(const NetworkModel& model) : model_(model) {}
  static std::vector<Group> groups_of(const NetworkModel& model);
  Status add(Group group);
  Status couple();
  double input(const NetworkState& state, const Input& from) const noexcept;
  void flow(NetworkState& state, const Block& block) const noexcept;
  void push(NetworkState& state) const noexcept;
  void arrive(NetworkState& state, const Block& block) const noexcept;
  void send_waves(NetworkState& state) const noexcept;

  /// Where a mass is.
  struct Place {
    int block, row;
  };

  const NetworkModel& model_;
  std::vector<Block> blocks_;
  std::vector<Place> places_;
  Couplings couplings_;
};

}  // namespace tactus
