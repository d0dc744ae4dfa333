#pragma once

#include <array>
#include <vector>

#include "engine/physics/numbers.h"
#include "engine/physics/solvers/critical_low_pass.h"

namespace tactus {

/// A force between two slots that follows from their motion in the step that is being made:
///   F = still + resistance * motion,   motion: of `lower` towards `upper` [m].
struct Touch {
  int coupling;  ///< contacts, then bonds
  double slope = 0.0, still = 0.0, resistance = 0.0;
  double free = 0.0;    ///< the motion if F were 0
  double motion = 0.0;  ///< as far as it is known
  double force = 0.0;
};

/// Where a network is. Everything that `Network::step` changes. [m], [J^1/2], [A]
struct NetworkState {
  Numbers position;      ///< of every slot: q
  Numbers moved;         ///< of centred schemes, in the last step: u = q - q-
  Numbers moved_before;  ///< in the step before it
  Numbers velocity;      ///< of the others, of every slot [m/s]
  Numbers change;        ///< workspace: e = u+ - u, or the way of the step
  Numbers root;          ///< of each contact's and bond's energy: psi
  Numbers loss;          ///< of each contact: r [s/m]
  Numbers slipped;       ///< of each bond: 0 while it holds, else the sign of n where it slipped
  Numbers sliding;       ///< of each friction: the sign of its velocity, 0 while it holds
  Numbers rub;           ///< of each friction: its force in the last step [N]
  Numbers slide;         ///< of each friction: its velocity in the last step
  Numbers current;       ///< of each coil (centred schemes: half a step ago)
  Numbers mean_current;  ///< of each coil, over the last step
  Numbers voltage;       ///< on each coil in the last step
  Numbers force;         ///< of each applied force in the last step
  Numbers wave;          ///< into each port in the last step
  Numbers wave_back;     ///< out of each port, mean of the last frame
  Numbers normal;        ///< of each friction in the last step
  Numbers held;          ///< inputs of the last frame
  std::vector<CriticalLowPass::State> low_pass;  ///< of each input with a bandwidth
  bool settled = false;                          ///< driven points have found their first place

  /// With `audit` each step of a solver that keeps account adds up what went in and what was lost [J].
  bool audit = false;
  double supplied = 0.0, dissipated = 0.0;

  /// All lists of numbers that the next step depends on.
  static constexpr auto memory() {
    return std::array{&NetworkState::position,  &NetworkState::moved,   &NetworkState::moved_before,
                      &NetworkState::velocity,  &NetworkState::root,    &NetworkState::loss,
                      &NetworkState::slipped,   &NetworkState::sliding, &NetworkState::rub,
                      &NetworkState::slide,     &NetworkState::current, &NetworkState::mean_current,
                      &NetworkState::voltage,   &NetworkState::force,   &NetworkState::wave,
                      &NetworkState::wave_back, &NetworkState::normal,  &NetworkState::held};
  }

  std::vector<Touch> touching;
  Numbers next;                 ///< workspace: driven points' next place, by slot
  Numbers flow, entering;       ///< workspace of the exact scheme: where it goes, and from what
  Numbers matrix, right, work;  ///< workspace
};

}  // namespace tactus
