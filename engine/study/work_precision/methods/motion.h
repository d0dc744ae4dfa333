#pragma once
// Thread: [control]

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <vector>

#include "engine/physics/network_model.h"

namespace tactus {

/// The equations of motion of a network, M x'' = F(x, x'), over one step: with u = (positions of the masses,
/// charges of the coils with an inductance), M = (masses, inductances). Forces, voltages and waves are held,
/// driven points go in a straight line from its start to its end.
class Motion {
 public:
  using Vector = Eigen::VectorXd;
  using Triplets = std::vector<Eigen::Triplet<double>>;

  explicit Motion(const NetworkModel& model);

  int size() const { return static_cast<int>(mass_.size()); }
  const Vector& mass() const { return mass_; }
  double k() const { return model_.k; }

  /// The state at the start of a step, its inputs, and the losses of the contacts that close in it.
  void begin(NetworkState& state);
  const Vector& positions() const { return x_; }
  const Vector& velocities() const { return v_; }
  /// Forces, voltages and waves.
  const Vector& entering() const { return entering_; }

  /// F at a share of the step: of springs, dampers, coils and ports, without what enters.
  void linear_force(double share, const Vector& x, const Vector& v, Vector& force);
  /// Adds the forces of the contacts that are closed. True: some are.
  bool add_contacts(double share, const Vector& x, const Vector& v, Vector& force);
  /// Adds -a dF/dx - b dF/dv from row and column `at` on.
  void add_linear_slopes(double a, double b, int row, int column, Triplets& entries) const;
  void add_contact_slopes(double share, const Vector& x, const Vector& v, double a, double b, int row,
                          int column, Triplets& entries);
  /// What the contacts store, its slopes, and how much of it the driven points give per step as they move
  /// from `before` to the end of this one.
  double contact_energy(const Vector& x, Vector& slopes, const std::vector<double>& before, double& driven);
  /// Of the driven points: where they are at the start of the step.
  const std::vector<double>& driven() const { return from_; }
  /// What their losses add to their forces.
  void add_losses(const Vector& x, const Vector& v, Vector& force);

  /// Ends the step: into the state, and the waves that go out.
  void end(const Vector& x, const Vector& v, NetworkState& state);

  /// [any] Of a state at a frame.
  double current(const NetworkState& state, int coil) const;
  double energy(const NetworkState& state) const;

  /// Multiplications so far, as the solvers of networks count them.
  double multiplications() const { return multiplications_; }
  void count(double multiplications) { multiplications_ += multiplications; }

 private:
  struct Closed {
    const NetworkModel::Contact* contact;
    double depth, speed, loss;
  };
  template <class Each>
  bool each_closed(double share, const Vector& x, const Vector& v, Each each);
  double place(double share, const Vector& x, int slot) const;
  double speed(const Vector& v, int slot) const;
  void push(int lower, int upper, double by, Vector& force) const;
  template <class Add>
  void each_damper(Add add) const;

  const NetworkModel& model_;
  Vector mass_, x_, v_, entering_;
  std::vector<int> charge_;  ///< of each coil: its row, or -1
  std::vector<double> from_, to_, loss_;
  double multiplications_ = 0;
};

}  // namespace tactus
