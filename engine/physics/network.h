#pragma once

#include <span>
#include <vector>

#include "engine/core/error.h"
#include "engine/core/units.h"
#include "engine/physics/band_solver.h"
#include "engine/physics/contact_law.h"
#include "engine/physics/critical_low_pass.h"
#include "engine/physics/elements.h"
#include "engine/physics/link_operator.h"
#include "engine/physics/mass_row.h"
#include "engine/physics/numbers.h"

namespace tactus {

enum class Solver {
  Passive,   ///< never makes energy, whatever the stiffness
  Explicit,  ///< the cheapest for many masses; unstable when too stiff
};

/// Where a network is. Everything that `Network::step` changes. [m], [J^1/2], [A]
struct NetworkState {
  Numbers position;                              ///< of every point: q
  Numbers moved;                                 ///< in the last step: u = q - q-
  Numbers moved_before;                          ///< in the step before it
  Numbers change;                                ///< workspace: e = u+ - u
  Numbers root;                                  ///< of each contact's energy, half a step ago: psi
  Numbers loss;                                  ///< of each contact: r [s/m]
  Numbers current;                               ///< of each coil, half a step ago
  Numbers mean_current;                          ///< of each coil, centred on the last step
  Numbers voltage;                               ///< on each coil in the last step
  Numbers force;                                 ///< of each applied force in the last step
  std::vector<CriticalLowPass::State> low_pass;  ///< of each drive with a bandwidth
  Numbers held;                                  ///< inputs of the last frame
  bool settled = false;                          ///< driven points have found their first place

  /// With `audit` each step of the passive solver adds up what went in and what was lost [J], for about twice
  /// the time.
  bool audit = false;
  double supplied = 0.0, dissipated = 0.0;

  /// Workspace for the contacts that touch.
  struct Touch {
    int contact;
    double slope, still, resistance, motion;  ///< F = still + resistance * motion; motion if F were 0
    double force;
  };
  std::vector<Touch> touching;
  Numbers matrix, right;
};

/// Masses on a line, joined by springs, contacts and coils, stepped at a fixed rate k^-1 = rate * oversample.
///
/// With q the positions, u = q - q- and e = q+ - 2q + q- both solvers step
///     A e = f - K q - C u/k - (contacts),   u+ = u + e,   q+ = q + u+,
/// which in this form neither loses nor gains energy by rounding. C holds the dampers and, for each coil,
/// what is left when its current is eliminated, Bl^2 / (2L/k + R).
///
///  - Explicit: A = M/k^2; contacts from the present state: the mass-interaction scheme of CORDIS-ANIMA
///  (Cadoz,
///    Luciani, Florens, CMJ 17(1), 1993). One mass on a spring is stable while k^2 K/m + 2 k C/m < 4.
///  - Passive: A = M/k^2 + C/2k: dampers and coils centred. Springs are explicit if all of them together are
///    stable so (largest eigenvalue of M^-1 K below 4/k^2, 1 % to spare), else all are averaged over three
///    instants and A has K/4 more: never unstable, but frequencies fall towards half the rate
///    (`springs_averaged`). Contacts by quadratised energy, one linear solve a step over those that touch
///    (Ducceschi, Bilbao, Willemsen, Serafin, JASA 149, 2021). Stored energy never grows but by what is put
///    in.
///
/// Forces and voltages of frame n are held until frame n + 1; at the instant of a frame the centred scheme
/// sees the mean of both sides, so the hold's half frame of delay is reproduced to second order. Driven
/// points go in a straight line to the position of frame n until frame n + 1. On the first frame they, and
/// hands, are there already. What is asked of a state at frame n depends on inputs before frame n only.
class Network {
 public:
  /// [control] `signals` inputs are handed to each step. rate > 0, 1 <= oversample <= 64. The numbers of the
  /// elements are in their ranges and their points exist (asserted: the graph file was checked before).
  /// Errors: OutOfRange if contacts or dampers join so many masses that the passive solver's matrix gets too
  /// large.
  static Result<Network> make(NetworkElements elements, int signals, Hertz rate, Solver solver,
                              int oversample);

  /// [control] Allocates; at the start of the network.
  NetworkState initial_state() const;
  /// [realtime] Back to the start.
  void reset(NetworkState& state) const noexcept;
  /// [realtime] Goes on from the state of a network of the same elements with other numbers: positions and
  /// motions stay, what contacts store follows from the indentation (energy changes with the stiffness,
  /// nothing jumps).
  void adopt(NetworkState& state, const NetworkState& before) const noexcept;
  /// [realtime] From frame n to n + 1 with the inputs of frame n.
  void step(NetworkState& state, const double* inputs) const noexcept;

  /// [realtime] Of a point, in the order of the elements.
  double position(const NetworkState& state, int point) const noexcept;
  /// Second order in k, exact for a constant acceleration: (3q - 4q- + q--) / 2k.
  double velocity(const NetworkState& state, int point) const noexcept;
  double extension(const NetworkState& state, int spring) const noexcept;
  /// Tension.
  double spring_force(const NetworkState& state, int spring) const noexcept;
  /// Never below 0.
  double indentation(const NetworkState& state, int contact) const noexcept;
  double contact_force(const NetworkState& state, int contact) const noexcept;
  double applied_force(const NetworkState& state, int force) const noexcept;
  double current(const NetworkState& state, int coil) const noexcept;
  double coil_force(const NetworkState& state, int coil) const noexcept;
  /// Stored in masses, springs, contacts and inductances, half a step before the frame: what the passive
  /// solver conserves exactly.
  double energy(const NetworkState& state) const noexcept;

  /// [any]
  bool springs_averaged() const { return averaged_; }
  /// Largest |eigenvalue| of one step without contacts: above 1 the linear part is unstable. O(masses^3).
  double spectral_radius() const;

 private:
  struct ContactModel {
    int lower, upper;
    double offset, loss;
    double loss_speed;  // r v where a restitution sets it, else 0
    ContactLaw law;
  };
  struct CoilModel {
    int on, against;
    double force_factor, inductance, resistance;
    double memory, impedance;  // 2L/k, 2L/k + R
    double half_step_decay;    // exp(-R k / 2L)
    Drive voltage;
  };
  struct Driven {
    int slot;
    Drive drive;
    int low_pass;  // place in low_passes_, or -1
  };
  /// What the change of a driven point does to a mass: the columns of A outside the masses.
  struct Coupling {
    int mass, driven;
    double a;
  };
  struct Links;

  Network() = default;
  void take_points(NetworkElements& elements);
  void take_links(const NetworkElements& elements);
  Driven driven(int slot, const Drive& drive);
  void choose_springs();
  double stiffest() const;
  Links assemble() const;
  Status factor(const Links& links);
  void couple_contacts();
  void line_up(std::vector<double> constant);
  bool is_mass(int slot) const { return slot < masses_; }

  void start_moving(NetworkState& state) const noexcept;
  void store_energy(NetworkState& state) const noexcept;
  void settle(NetworkState& state, const double* inputs) const noexcept;
  void substep(NetworkState& state, const double* inputs, int part) const noexcept;
  void start_forces(NetworkState& state) const noexcept;
  void move_driven(NetworkState& state, const double* inputs, int part) const noexcept;
  void add_forces(NetworkState& state, const double* inputs, int part) const noexcept;
  void add_coils(NetworkState& state, const double* inputs, int part) const noexcept;
  void step_currents(NetworkState& state) const noexcept;
  void advance(NetworkState& state) const noexcept;
  void push(NetworkState& state, const ContactModel& contact, double force) const noexcept;
  void watch_touch(NetworkState& state, std::size_t contact, double n, double motion) const noexcept;
  void push_contacts(NetworkState& state) const noexcept;
  void solve_masses(NetworkState& state) const noexcept;
  void find_touching(NetworkState& state) const noexcept;
  void solve_forces(NetworkState& state) const noexcept;
  void solve_touching(NetworkState& state) const noexcept;
  void audit(NetworkState& state) const noexcept;
  double indentation_now(const NetworkState& state, const ContactModel& contact) const noexcept;

  int signals_ = 0, oversample_ = 1, masses_ = 0;
  double k_ = 0.0;  // seconds a step
  Solver solver_ = Solver::Passive;
  bool averaged_ = false;
  // Slots: masses in the order of the elements, then driven points, then fixed ones.
  std::vector<int> slot_;
  std::vector<double> mass_, scale_, constant_, start_position_, start_velocity_;
  std::vector<Spring> springs_;  // these and all that follow name slots
  std::vector<ContactModel> contacts_;
  std::vector<CoilModel> coils_;
  std::vector<Driven> forces_, motions_;
  std::vector<CriticalLowPass> low_passes_;
  LinkOperator links_;
  // Of many masses and the explicit solver: links between neighbours, and those that jump or are driven.
  bool in_row_ = false;
  MassRow row_;
  LinkOperator jumps_;
  std::vector<Coupling> couplings_;
  BandSolver solver_matrix_;
  // Column c of A^-1 D is what a force in contact c does to the masses; W = D^T A^-1 D, to the indentations.
  std::vector<double> columns_, mutual_;
};

}  // namespace tactus
