#pragma once

// Thread: [any]
#include <array>
#include <vector>

#include "engine/physics/numbers.h"
#include "engine/physics/solvers/critical_low_pass.h"

namespace tactus {

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
};

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
  bool settled = false;                          ///< driven points have found their first place

  /// With `audit` each step of a solver that keeps account adds up what went in and what was lost [J].
  bool audit = false;
  double supplied = 0.0, dissipated = 0.0;

  /// All lists of numbers that the next step depends on.
  static constexpr auto memory() {
    return std::array{&NetworkState::position,          &NetworkState::moved,   &NetworkState::moved_before,
                      &NetworkState::velocity,          &NetworkState::root,    &NetworkState::loss,
                      &NetworkState::slipped,           &NetworkState::sliding, &NetworkState::friction_force,
                      &NetworkState::friction_velocity, &NetworkState::current, &NetworkState::mean_current,
                      &NetworkState::voltage,           &NetworkState::force,   &NetworkState::wave,
                      &NetworkState::wave_back,         &NetworkState::normal,  &NetworkState::held};
  }

  std::vector<ActiveCoupling> active;
  AlignedNumbers next;                 ///< workspace: driven points' next place, by slot
  AlignedNumbers flow, entering;       ///< workspace of the exact solver: where it goes, and from what
  AlignedNumbers matrix, right, work;  ///< workspace
};

}  // namespace tactus
