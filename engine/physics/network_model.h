#pragma once

// Thread: [any], except where a function says otherwise
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "engine/core/index.h"
#include "engine/core/units.h"
#include "engine/physics/couplings/friction_step.h"
#include "engine/physics/elements.h"
#include "engine/physics/low_pass_kernel.h"
#include "engine/physics/numbers.h"
#include "engine/physics/solvers/link_operator.h"

namespace tactus {

/// Two equal real poles:  y'' = w^2 (x - y) - 2 w y',  stepped exactly for an input held over the step.
/// The -3 dB point is `bandwidth`: w = 2 pi bandwidth / sqrt(sqrt(2) - 1). The step response never
/// overshoots.
class CriticalLowPass {
 public:
  using State = tactus_critical_low_pass;

  /// bandwidth > 0.
  CriticalLowPass(Hertz bandwidth, Hertz step_rate)
      : pole_(2.0 * std::numbers::pi * bandwidth.value / std::sqrt(std::numbers::sqrt2 - 1.0)),
        step_(1.0 / step_rate.value),
        decay_(std::exp(-pole_ * step_)) {}

  /// [realtime]
  void step(State& state, double input) const noexcept {
    tactus_critical_low_pass_step(&state, input, pole_, step_, decay_);
  }

  /// [any] Of the pole [rad/s], and what a step leaves.
  double pole() const { return pole_; }
  double decay() const { return decay_; }

 private:
  double pole_, step_, decay_;
};

/// A contact or a bond that acts in the step that is being made, linear in the motion of its ends:
///   force = static_force + resistance * motion,   motion: of `lower` towards `upper` [m].
/// With `Couplings::Method::Explicit` only `force` counts, known from the start; with `Gradient` the first
/// three are those of the last iteration.
struct ActiveCoupling {
  int coupling;               ///< contacts, then bonds
  double slope = 0.0;         ///< of the root of the energy, over the step (quadratised energy)
  double static_force = 0.0;  ///< without motion [N]
  double resistance = 0.0;    ///< [N/m]
  double free_motion = 0.0;   ///< without this force
  double motion = 0.0;        ///< with all forces: after the solution (Gradient: of the last iteration)
  double force = 0.0;         ///< [N]
  bool bounces = false;       ///< over within the step: the damper of its restitution
  bool released = false;      ///< it would have to pull
};

/// A damper with z k / m above this stops its masses within a step.
inline constexpr double kStopsWithinStep = 4.0;
/// Such a damper counts towards the end of the step by theta instead of 1/2:  theta - 1/2,
/// theta = 1 - 32 / r^3 where r = z k / m > 4, else 1/2.
inline double stiff_weight(double r) noexcept {
  return r > kStopsWithinStep ? 0.5 - 32.0 / (r * r * r) : 0.0;
}

/// Where a network is. Everything that `Network::step` changes. [m], [J^1/2], [A]
struct NetworkState {
  AlignedNumbers position;           ///< of every slot: q
  AlignedNumbers moved;              ///< of centred solvers, in the last step: u = q - q-
  AlignedNumbers moved_before;       ///< in the step before it
  AlignedNumbers velocity;           ///< of the others, of every slot [m/s]
  AlignedNumbers change;             ///< workspace: e = u+ - u, or the way of the step
  AlignedNumbers root;               ///< of each contact's and bond's energy: psi
  AlignedNumbers loss;               ///< of each contact: r [s/m]
  AlignedNumbers slipped;            ///< of each bond: 0 while it holds, else the sign of n where it slipped
  AlignedNumbers sliding;            ///< of each friction: the sign of its velocity, 0 while it holds
  AlignedNumbers friction_force;     ///< of each friction: its force in the last step [N]
  AlignedNumbers friction_velocity;  ///< of each friction: its velocity in the last step
  AlignedNumbers current;            ///< of each coil (centred solvers: half a step ago)
  AlignedNumbers mean_current;       ///< of each coil, over the last step
  AlignedNumbers voltage;            ///< on each coil in the last step
  AlignedNumbers force;              ///< of each applied force in the last step
  AlignedNumbers wave;               ///< into each port in the last step
  AlignedNumbers wave_back;          ///< out of each port, mean of the last frame
  AlignedNumbers normal;             ///< of each friction in the last step
  AlignedNumbers held;               ///< inputs of the last frame
  std::vector<CriticalLowPass::State> low_pass;  ///< of each input with a bandwidth
  bool started = false;                          ///< has made a step
  bool settled = false;                          ///< nothing is new
  /// What has not found its first place: driven points, low-passes, bonds.
  std::vector<bool> new_motion, new_low_pass, new_bond;

  /// All lists of numbers that the next step depends on.
  static constexpr auto memory() {
    using S = NetworkState;
    return std::array{
        &S::position, &S::moved,   &S::moved_before,   &S::velocity,          &S::root,    &S::loss,
        &S::slipped,  &S::sliding, &S::friction_force, &S::friction_velocity, &S::current, &S::mean_current,
        &S::voltage,  &S::force,   &S::wave,           &S::wave_back,         &S::normal,  &S::held};
  }

  std::vector<FrictionMemory> friction;  ///< of each friction; the next step depends on it too
  std::vector<FrictionForce> rubbed;     ///< workspace: of each friction, as far as it is solved
  std::vector<ActiveCoupling> active;
  bool let_go = false;                 ///< workspace: a contact that would have to pull was released
  AlignedNumbers along;                ///< workspace: of each bond of several axes, its direction
  AlignedNumbers next;                 ///< workspace: driven points' next place, by slot
  AlignedNumbers flow, entering;       ///< workspace of the exact solver: where it goes, and from what
  AlignedNumbers matrix, right, work;  ///< workspace
};

/// x_lower - x_upper of a link.
template <class Numbers, class Link>
double between(const Numbers& x, const Link& link) noexcept {
  return x[index(link.lower)] - x[index(link.upper)];
}
/// x_upper - x_lower of a spring, along its direction.
template <class Numbers>
double span(const Numbers& x, const Spring& spring) noexcept {
  if (spring.axes == 1) return x[index(spring.upper)] - x[index(spring.lower)];
  double sum = 0.0;
  for (int a = 0; a < spring.axes; ++a)
    sum += spring.along[index(a)] * (x[index(spring.upper + a)] - x[index(spring.lower + a)]);
  return sum;
}
template <class Numbers>
double extension(const Numbers& x, const Spring& spring) noexcept {
  return span(x, spring) - spring.rest;
}
/// x_lower - x_upper of a bond, axis by axis; unused axes are 0.
using Direction = std::array<double, kMostAxes>;
template <class Numbers>
Direction apart(const Numbers& x, const Bond& bond) noexcept {
  Direction r{};
  for (int a = 0; a < bond.axes; ++a) r[index(a)] = x[index(bond.lower + a)] - x[index(bond.upper + a)];
  return r;
}
inline double dot(const Direction& a, const Direction& b) noexcept {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
inline double length(const Direction& r) noexcept { return std::sqrt(dot(r, r)); }
/// r / |r|; 0 where r is.
inline Direction unit(const Direction& r) noexcept {
  const double l = length(r);
  return l > 0.0 ? Direction{r[0] / l, r[1] / l, r[2] / l} : Direction{};
}
/// What the law of a bond depends on: n.
template <class Numbers>
double stretch(const Numbers& x, const Bond& bond) noexcept {
  return bond.axes == 1 ? between(x, bond) : length(apart(x, bond)) - bond.rest;
}
/// How deep a contact is; below 0 where it is open.
template <class Numbers>
double indentation(const Numbers& x, const Contact& contact) noexcept {
  return between(x, contact) + contact.offset;
}

/// The elements of a network as all solvers use them. Places are *slots*: masses in the
/// order of the elements, then driven points, then fixed ones. Never changes once it is made.
struct NetworkModel {
  struct Contact : tactus::Contact {
    double loss_speed;  ///< r v where a restitution sets it, else 0
    ContactLaw law;
  };
  struct Coil : tactus::Coil {
    double memory, impedance;  ///< 2L/k, 2L/k + R
    double half_step_decay;    ///< exp(-R k / 2L)
  };

  /// [control] Steps of `step_s` seconds; `signals` inputs are handed to each frame.
  NetworkModel(NetworkElements elements, int signals, double step_s);

  /// K and C as entries: rows are masses, columns masses and driven points; what fixed points do is constant.
  /// `LinkOperator::Entry::b` is C/k, `inertia` what `stiff_inertia` adds, over k^2.
  struct Links {
    std::vector<LinkOperator::Entry> entries;
    std::vector<double> constant;
  };
  /// [control] Coils with an inductance hold a current of their own: with `eliminated`, as the damper that
  /// centred steps leave of them; else not at all.
  Links links(bool eliminated = true) const;
  /// [control] An upper bound of the largest eigenvalue of M^-1 (k_share K + b_share C/k), exact for small
  /// networks.
  double stiffest(double k_share, double b_share) const;

  /// [any] What a damper z [N s/m] that stops its masses within a step, r = z k / m, is weighted with towards
  /// the end of the step: as an inertia between its ends, over k^2 [N/m].
  double stiff_inertia(double damping, double r) const noexcept { return damping * stiff_weight(r) / k; }

  bool is_mass(int of) const { return of < masses; }
  bool moves(int of) const { return of < masses + static_cast<int>(motions.size()); }

  /// [any] Whether a bond acts along the line between bodies of several axes.
  bool has_lines() const {
    return std::any_of(bonds.begin(), bonds.end(), [](const Bond& bond) { return bond.axes > 1; });
  }

  /// [realtime] Kinetic energy and that of the springs, where a state has velocities.
  double linear_energy(const NetworkState& state) const noexcept;
  /// [realtime] `sum` and the energy of the inductances.
  double with_inductances(double sum, const NetworkState& state) const noexcept;
  /// [realtime] Adds to `wave_back` what goes out of each port, whose slot goes `way(slot)` in the step.
  template <class Way>
  void send_waves(NetworkState& state, Way way) const noexcept {
    for (std::size_t i = 0; i < ports.size(); ++i)
      state.wave_back[i] += state.wave[i] - ports[i].impedance * way(ports[i].on) / k;
  }

  double k;  ///< seconds a step
  int signals = 0, masses = 0;
  std::vector<int> slot;                                            ///< of each point of the elements
  std::vector<double> mass, scale, start_position, start_velocity;  ///< scale: k^2 / mass
  std::vector<Spring> springs;                                      ///< these and all that follow name slots
  std::vector<Contact> contacts;
  std::vector<Coil> coils;
  std::vector<AppliedForce> forces;
  std::vector<AppliedForce> motions;  ///< the driven points
  std::vector<Friction> frictions;
  std::vector<Bond> bonds;
  std::vector<WavePort> ports;
  std::vector<CriticalLowPass> low_passes;

 private:
  void add_line(Links& links, const Spring& spring, double inertia) const;
  void filter(NetworkInput& input);
  void take_points(NetworkElements& elements);
  void take_links(NetworkElements& elements);
};

}  // namespace tactus
