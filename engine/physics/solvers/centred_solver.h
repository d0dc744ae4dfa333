#pragma once

// Thread: [any], except where a function says otherwise
#include <memory>
#include <vector>

#include "engine/core/error.h"
#include "engine/physics/couplings/couplings.h"
#include "engine/physics/solvers/mass_row.h"
#include "engine/physics/solvers/network_solver.h"
#include "engine/physics/solvers/sparse_solver.h"

namespace tactus {

/// Solvers over three instants. With q the positions, u = q - q- and e = q+ - 2q + q- a step solves
///     A e = f - K q - C u/k - (couplings),   u+ = u + e,   q+ = q + u+,
/// which in this form neither loses nor gains energy by rounding. C holds the dampers and ports and, for each
/// coil, what is left when its current is eliminated, Bl^2 / (2L/k + R).
///
///  - Explicit: A = M/k^2; contacts from the present state: mass-interaction, as in CORDIS-ANIMA (Cadoz,
///    Luciani, Florens, CMJ 17(1), 1993). One mass on a spring is stable while k^2 K/m + 2 k C/m < 4.
///  - Passive: A = M/k^2 + C/2k: dampers and coils centred. Springs are explicit if all of them together are
///    stable so (largest eigenvalue of M^-1 K below 4/k^2, 1 % to spare), else all are averaged as below.
///    Contacts by quadratised energy: stored energy never grows but by what is put in.
///  - Implicit: A = M/k^2 + C/2k + K/4, the trapezoidal rule (Newmark, J. Eng. Mech. 85, 1959, beta = 1/4):
///    never unstable, but frequencies fall towards half the rate by (w k)^2 / 12. Contacts by the discrete
///    gradient.
class CentredSolver final : public NetworkSolver {
 public:
  enum class Kind { Explicit, Passive, Implicit };

  /// [control] Errors: OutOfRange if the numbers are too far apart to be solved, or the couplings too many.
  static Result<std::unique_ptr<NetworkSolver>> make(const NetworkModel& model, Kind kind);

  void start(NetworkState& state) const noexcept override;
  void store_energy(NetworkState& state) const noexcept override;
  void step(NetworkState& state) const noexcept override;
  double energy(const NetworkState& state) const noexcept override;
  /// Second order in k, exact for a constant acceleration: (3q - 4q- + q--) / 2k.
  double velocity(const NetworkState& state, int slot) const noexcept override;
  /// From half a step ago to now: exact for the voltage that was held last, at a constant speed.
  double current(const NetworkState& state, int coil) const noexcept override;
  bool centred() const override { return true; }
  bool springs_averaged() const override { return averaged_; }
  Cost cost() const override;

 private:
  /// What the change of a driven point does to a mass: the columns of A outside the masses.
  struct DrivenColumn {
    int mass, driven;
    double a;
  };

  explicit CentredSolver(const NetworkModel& model, Kind kind) : model_(model), kind_(kind) {}
  bool factored() const { return kind_ != Kind::Explicit; }
  Result<SparseSolver> solver_of(double k_share, double b_share) const;
  Status factor();
  Status slow_start();
  Status couple();
  void line_up(std::vector<double> constant);

  void add_applied(NetworkState& state) const noexcept;
  void add_coils(NetworkState& state) const noexcept;
  void move_driven(NetworkState& state) const noexcept;
  void start_forces(NetworkState& state) const noexcept;
  void push(NetworkState& state) const noexcept;
  void step_currents(NetworkState& state) const noexcept;
  void bend(NetworkState& state) const noexcept;
  void slow(NetworkState& state) const noexcept;
  double softened(std::size_t coupling, double stiffness, double force) const noexcept;
  void send_waves(NetworkState& state) const noexcept;
  void advance(NetworkState& state) const noexcept;
  void audit(NetworkState& state) const noexcept;
  double lost(const NetworkState& state, const ActiveCoupling& link) const noexcept;
  /// How far a slot goes in the middle of the step, as dampers see it.
  double travel(const NetworkState& state, int slot) const noexcept;

  const NetworkModel& model_;
  Kind kind_;
  bool averaged_ = false;
  LinkOperator links_;
  // Of many masses and the explicit solver: links between neighbours, and those that jump or are driven.
  bool in_row_ = false;
  std::vector<double> constant_;
  MassRow row_;
  LinkOperator jumps_;
  std::vector<DrivenColumn> driven_columns_;
  SparseSolver solver_;
  std::vector<double> start_velocity_;  ///< as the first step sees it
  Couplings couplings_;
};

}  // namespace tactus
