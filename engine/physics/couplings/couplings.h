#pragma once

// Thread: [any], except where a function says otherwise
#include <functional>
#include <span>
#include <vector>

#include "engine/core/error.h"
#include "engine/physics/network_model.h"

namespace tactus {

/// The forces between two slots that are not linear (contacts, bonds, frictions), solved together with the
/// motion that they cause. Without them coupling c would move by `free_c` [m] in the step; with them
///   motion_c = free_c - sum_c' W_cc' F_c',   W = D^T A^-1 D,
/// column c of D having 1 at the lower slot and -1 at the upper one. The solvers differ in what a motion is
/// (over two steps or one), in A, and in how a contact's force follows from its motion.
///
/// **Quadratised energy** (Ducceschi, Bilbao, Willemsen, Serafin, JASA 149, 2021): F = g (psi + psi+)/2 with
/// psi+ = psi + g * (share of the motion), g the slope of the root of the energy; one linear solve a step.
/// The bodies lose exactly what psi^2/2 gains, whatever g is. So in the first step of a contact g is the
/// slope of the chord to the predicted root: the plain slope, which has a corner at n = 0, would
/// leave psi off by a part that depends on the phase, and the contact's time with it (8e-3 at 20 steps a
/// contact; with the chord 1e-3).
///
/// **Discrete gradient** (Bilbao, Torin, Chatziioannou, Acta Acustica 101, 2015): F = (phi(n+) - phi(n-)) /
/// (n+ - n-), solved by Newton's method: more work, twice as exact in time.
///
/// **Bonds** have the discrete gradient too, with every method: g is the chord of psi over the motion of the
/// step, found by iteration (a linear bond has one chord only).
///
/// **Bonds of several axes** act along a line that turns. From r_0 to r_1, the distances at the ends of the
/// interval over which psi is stored, |r_1| - |r_0| = a . (r_1 - r_0) with a = (r_0 + r_1) / (|r_0| + |r_1|):
/// the force along a, with the chord of psi over the length, keeps energy, momentum and (being along r_0 +
/// r_1) angular momentum (Simo, Tarnow & Wong, Comput. Methods Appl. Mech. Eng. 100, 1992). a is found by the
/// same iteration. Such a bond has a row of W for each axis.
///
/// Losses F r v use the predicted force, so that the ratio of the speeds is right for the potential that the
/// solver has. A contact that is deepest before its first step ends has no predicted force: with quadratised
/// energy it would lose nothing, with the discrete gradient what its last iteration gives. For that step it
/// is a damper with the restitution e that r gives at this speed:  F = R motion,  R W_cc = (1 + e) / (1 - e),
/// in motions over one step and over two.
class Couplings {
 public:
  enum class Method {
    Centred,   ///< quadratised energy, motions over two steps
    Gradient,  ///< discrete gradient, motions over two steps
    Exact,     ///< quadratised energy, motions over one step
    Explicit,  ///< contacts and bonds from the present state; frictions with motions over two steps
  };

  /// [control] `respond` turns a column of D, one number a mass, into A^-1 times it. Errors: OutOfRange if
  /// there are more couplings than memory for how each acts on each.
  static Result<Couplings> make(const NetworkModel& model, Method method,
                                const std::function<void(std::span<double>)>& respond);

  /// [realtime] Sets the energy of contacts and bonds from the positions, at the instant that the method
  /// stores it for: half a step ago where motions are over two steps.
  void store_energy(NetworkState& state) const noexcept;
  /// [realtime] Finds the active couplings and solves their forces, given the motion of each slot
  /// without them: share * state.moved + state.change, as the method counts motions.
  void solve(NetworkState& state) const noexcept;
  /// [realtime] Stores the solution: energies, bonds that slip, frictions that slide.
  void finish(NetworkState& state) const noexcept;

  /// [realtime] Adds what the solved forces do: to the masses of `change`, or force by force to `push(slot,
  /// newton)`.
  void move(NetworkState& state) const noexcept;
  template <class Push>
  void push_all(const NetworkState& state, Push push) const noexcept {
    for (const auto& link : state.active) {
      const auto c = index(link.coupling);
      for (int a = 0; a < ends_[c].axes; ++a) {
        const double force = lines_ ? share(state, c, a) * link.force : link.force;
        push(ends_[c].lower + a, -force);
        push(ends_[c].upper + a, force);
      }
    }
    for (std::size_t f = 0; f < frictions(); ++f) {
      push(model_->frictions[f].lower, -state.friction_force[f]);
      push(model_->frictions[f].upper, state.friction_force[f]);
    }
  }

  /// [realtime] The motion of a coupling for the present `state.change`.
  double motion(const NetworkState& state, std::size_t coupling) const noexcept;
  /// [realtime] How deep a contact is, and was a step ago, as the discrete gradient counts it.
  double depth(const NetworkState& state, std::size_t contact) const noexcept {
    return indentation(state, contact) + state.root[contact];
  }
  double depth_before(const NetworkState& state, std::size_t contact) const noexcept {
    return depth(state, contact) - moved(state, contact);
  }

  /// [any] What was worked out when they were made: W, row by row from the first row that there is, A^-1 D by
  /// columns (empty: not needed), and the first row of each coupling.
  std::span<const double> mutual() const { return mutual_; }
  std::span<const double> columns() const { return columns_; }
  const std::vector<std::size_t>& rows() const { return rows_; }
  std::size_t row_count() const { return row_count_; }
  std::size_t first_row() const { return first_row_; }
  bool alone() const { return alone_; }

  bool empty() const { return ends_.empty(); }
  std::size_t count() const { return ends_.size(); }
  std::size_t frictions() const { return count() - first_friction(); }
  std::size_t first_friction() const { return model_->contacts.size() + model_->bonds.size(); }
  /// How far coupling c moves by a force of 1 N in c'. [m/N]
  double mutual(std::size_t c, std::size_t other) const { return by_rows(row_of(c), row_of(other)); }
  /// Of a bond: what a stiff damper adds, over k^2. [N/m]
  double inertia(std::size_t bond) const { return inertia_[bond]; }
  /// [realtime] Of all bonds of several axes: the line through their ends as they are.
  void find_lines(NetworkState& state) const noexcept;

 private:
  void lose_energy(NetworkState& state) const noexcept;
  int steps() const { return method_ == Method::Exact ? 1 : 2; }
  double slack() const { return steps() * model_->k; }
  std::size_t row_of(std::size_t c) const { return lines_ ? rows_[c] : c; }
  double by_rows(std::size_t row, std::size_t other) const {
    return mutual_[(row - first_row_) * row_count_ + other];
  }
  /// The component along an axis of the direction of a coupling.
  double share(const NetworkState& state, std::size_t c, int axis) const noexcept {
    return ends_[c].axes > 1 ? state.along[kMostAxes * (c - model_->contacts.size()) + index(axis)] : 1.0;
  }
  /// As `mutual`, along the present directions of both.
  double mutual_along(const NetworkState& state, std::size_t c, std::size_t other) const noexcept;
  double acting(const NetworkState& state, std::size_t c, std::size_t other) const noexcept {
    return lines_ ? mutual_along(state, c, other) : mutual(c, other);
  }
  /// Workspace where there are lines: of each row a force, and how far all of them move it.
  double* row_force(NetworkState& state) const noexcept {
    return state.along.data() + kMostAxes * model_->bonds.size();
  }
  double* row_motion(NetworkState& state) const noexcept { return row_force(state) + row_count_; }
  template <class Force>
  void respond_to(NetworkState& state, const Force& force_of) const noexcept;
  void respond_to_forces(NetworkState& state) const noexcept;
  double row_motion_along(NetworkState& state, std::size_t c) const noexcept;
  void solve_lines(NetworkState& state) const noexcept;
  template <class Part>
  double along(const NetworkState& state, std::size_t c, const Part& of) const noexcept;
  double axis_motion(const NetworkState& state, int lower, int upper) const noexcept;
  bool turn_line(NetworkState& state, ActiveCoupling& link) const noexcept;
  Direction line_before(const NetworkState& state, const Bond& bond) const noexcept;
  double moved(const NetworkState& state, std::size_t coupling) const noexcept;
  double indentation(const NetworkState& state, std::size_t coupling) const noexcept;
  double taken_by_contacts(const NetworkState& state, std::size_t coupling) const noexcept;
  double taken_by_friction(const NetworkState& state, std::size_t coupling) const noexcept;

  void find_contacts(NetworkState& state) const noexcept;
  bool predict(NetworkState& state, ActiveCoupling& link) const noexcept;
  double predicted_push(const NetworkState& state, std::size_t contact) const noexcept;
  bool bounce(ActiveCoupling& link, double approach, double loss) const noexcept;
  bool release(NetworkState& state, ActiveCoupling& link, double motion) const noexcept;
  double next_motion(const NetworkState& state, const ActiveCoupling& link) const noexcept;
  void find_bonds(NetworkState& state) const noexcept;
  bool update_bond(NetworkState& state, ActiveCoupling& link, double motion) const noexcept;
  bool update_bonds(NetworkState& state) const noexcept;
  void push_contacts(NetworkState& state) const noexcept;

  void solve_contacts(NetworkState& state) const noexcept;
  void solve_quadratised(NetworkState& state) const noexcept;
  void solve_gradient(NetworkState& state) const noexcept;
  void solve_linear(NetworkState& state) const noexcept;
  void follow(NetworkState& state, ActiveCoupling& link) const noexcept;
  bool missed_one(NetworkState& state) const noexcept;
  double solve_frictions(NetworkState& state, bool clings) const noexcept;
  void solve_friction(NetworkState& state, std::size_t friction, bool clings) const noexcept;
  double driven_jump(const NetworkState& state, const Friction& friction) const noexcept;
  bool one_breaks(const NetworkState& state) const noexcept;

  const NetworkModel* model_ = nullptr;
  Method method_ = Method::Centred;
  bool alone_ = true;  ///< no coupling acts on another
  struct Ends {
    int lower, upper, axes;
  };
  std::vector<Ends> ends_;
  bool lines_ = false;             ///< a bond has several axes
  std::vector<std::size_t> rows_;  ///< of each coupling: its first row
  std::size_t row_count_ = 0, first_row_ = 0;
  std::vector<double> columns_, mutual_;
  std::vector<double> inertia_;  ///< of each bond: what a stiff damper adds
};

/// [realtime] The loss of a contact whose bodies meet by `motion` in a step: its own, or that of its
/// restitution.
double loss_of_strike(const NetworkModel& model, std::size_t contact, double motion) noexcept;
/// [realtime] Sets the loss of a contact that begins, if it has a restitution: `n` is how
/// deep it is, `motion` how far it came in the last step.
void start_contact(const NetworkModel& model, NetworkState& state, std::size_t contact, double n,
                   double motion) noexcept;
/// [realtime] The loss of a contact at the start, where it moves by `motion` in a step.
void start_loss(const NetworkModel& model, NetworkState& state, std::size_t contact, double motion) noexcept;

}  // namespace tactus
