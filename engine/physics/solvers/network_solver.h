#pragma once

// Thread: [any], except where a function says otherwise
#include <memory>

#include "engine/core/error.h"
#include "engine/physics/network_model.h"

namespace tactus {

/// How a network is stepped; each is described where it is made.
enum class Solver {
  Explicit,   ///< the cheapest for many masses; unstable when too stiff (`make_centred_solver`)
  Passive,    ///< never makes energy, whatever the stiffness (`make_centred_solver`)
  Implicit,   ///< the trapezoidal rule and Newton's method: never unstable (`make_centred_solver`)
  Exact,      ///< no error in the linear part; small groups of masses (`make_exact_solver`)
  Reference,  ///< the motion itself, which the others are measured against (`make_reference_solver`)
  Auto,       ///< the cheapest of them that is stable and accurate (`choose_solver`)
};

struct SolverTables;

/// A way of stepping a network. It owns what is worked out when the network is made; the model outlives it.
class NetworkSolver {
 public:
  virtual ~NetworkSolver() = default;

  /// [realtime] From positions in `state` and the model's velocities to a consistent start.
  virtual void start(NetworkState& state) const noexcept = 0;
  /// [realtime] What the contacts hold follows from where everything is (after an edit of stiffnesses).
  virtual void store_energy(NetworkState& state) const noexcept = 0;
  /// [realtime] One step of k seconds, with forces, voltages, waves, normal forces and the driven points'
  /// next places in `state`. Adds to `wave_back` what goes out of each port.
  virtual void step(NetworkState& state) const noexcept = 0;
  /// [realtime] Stored in masses, springs, contacts, bonds and inductances, in the form that the solver
  /// conserves.
  virtual double energy(const NetworkState& state) const noexcept = 0;
  /// [realtime] Of a slot. [m/s]
  virtual double velocity(const NetworkState& state, int slot) const noexcept {
    return state.velocity[index(slot)];
  }
  /// [realtime] Of a coil. [A]
  virtual double current(const NetworkState& state, int coil) const noexcept = 0;

  /// [any] A step sees a held input at its instant, so between two frames the mean of both.
  virtual bool centred() const = 0;
  /// [any] Springs are averaged over the instants of a step: stable whatever the stiffness.
  virtual bool springs_averaged() const { return false; }
  /// [any] Multiplications of a step without contact, and of each closed contact.
  struct Cost {
    double step, contact;
  };
  virtual Cost cost() const = 0;
  /// [control] What it has worked out. Of others than explicit, passive, implicit and exact: nothing.
  virtual SolverTables tables() const;
};

/// Solvers over three instants. With q the positions, u = q - q- and e = q+ - 2q + q- a step solves
///     A e = f - K q - C u/k - (couplings),   u+ = u + e,   q+ = q + u+,
/// which in this form neither loses nor gains energy by rounding. C holds the dampers and ports and, for each
/// coil, what is left when its current is eliminated, Bl^2 / (2L/k + R).
///
///  - Explicit: A = M/k^2; contacts from the present state: mass-interaction, as in CORDIS-ANIMA (Cadoz,
///    Luciani, Florens, CMJ 17(1), 1993). One mass on a spring is stable while k^2 K/m + 2 k C/m < 4.
///  - Passive: A = M/k^2 + C/2k + V: dampers and coils centred, but for V, by which those that stop a mass
///  within
///    a step count towards its end (`NetworkModel::stiff_inertia`). So they do not ring at half the rate, as
///    the plain trapezoidal rule does: every mode of dampers and masses decays by a factor of -1/3 or more a
///    step, and by one near 0 where it is stiff. V acts as a mass would: it stores energy and never makes
///    any. Springs are explicit if all of them together are stable so (largest eigenvalue of M^-1 K below
///    4/k^2, 1 % to spare), else all are averaged as below. Contacts by quadratised energy: stored energy
///    never grows but by what is put in.
///  - Implicit: A = M/k^2 + C/2k + V + K/4, the trapezoidal rule (Newmark, J. Eng. Mech. 85, 1959, beta =
///  1/4):
///    never unstable, but frequencies fall towards half the rate by (w k)^2 / 12. Contacts by the discrete
///    gradient.
///
/// [control] `kind` is Explicit, Passive or Implicit. Errors: OutOfRange if the numbers are too far apart to
/// be solved, or the couplings too many.
Result<std::unique_ptr<NetworkSolver>> make_centred_solver(const NetworkModel& model, Solver kind);

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
///
/// [control] Errors: OutOfRange if a group is too large, or its numbers too far apart.
Result<std::unique_ptr<NetworkSolver>> make_exact_solver(const NetworkModel& model);

/// The motion of a network itself, a step at a time: `solver = "reference"`, what the other solvers are
/// measured against, and nothing that they are made of.
///     m x'' = sum of the forces of `elements.h`,   L i' = V - R i - Bl x'
/// Forces and voltages are held over a step, driven points go in a straight line from its start to its end.
///
///  - Few points without contacts: by the exponential of the matrix of the system, exact but for rounding.
///  - Otherwise by extrapolation of variable order and step to a local error of 1e-13, relative to the
///    largest position, velocity or current. A contact that opens or closes, a loss that begins or ends to
///    outweigh the contact's push, a friction that begins or ends to hold, a bond that slips or holds
///    again end a step of the integration at that very instant: every one integrates a smooth equation. With
///    a restitution the loss is set by the speed of each impact, at least 0.1 mm/s.
///
/// Not for real time: a step takes as long as it needs. A motion that cannot be followed leaves a state that
/// is not finite. [control]
std::unique_ptr<NetworkSolver> make_reference_solver(const NetworkModel& model);

}  // namespace tactus
