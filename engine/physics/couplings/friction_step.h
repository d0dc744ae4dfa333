#pragma once

// Thread: [any]
#include "engine/physics/couplings/force_laws.h"

namespace tactus {

/// What a friction keeps from step to step, beside the sign of its sliding.
struct FrictionMemory {
  /// A margin that is not known: at the start of the network; after a slide.
  static constexpr double kStart = -2.0, kUnknown = -1.0;
  double margin = kStart;  ///< what more it could have held with in the last step [N], >= 0
  double heat = 0.0;  ///< what it has taken in this slide: force times velocity, summed over its steps [W]
  double owed = 0.0;  ///< how much too large its force has been since it began to slide [N steps]
};

/// A step as a friction meets it: two bodies that without it would slide at `free`, and which a force slows
/// by `mobility` [m/s/N]. Both are means over the step, mean = (before + after) / 2. [m/s], [N]
struct FrictionStep {
  double normal = 0.0, free = 0.0, mobility = 0.0;
  double before = 0.0;   ///< at the start of the step
  double jump = 0.0;     ///< by how much driven points change it: halfway (centred), or at the start
  bool holds = false;    ///< it held in the step before
  bool centred = false;  ///< a body that stops in the step moves on at half its speed, else to where it stops
  bool clings = false;   ///< what cannot hold pushes with all that it can hold with, and does not slide yet
  FrictionMemory memory = {.margin = FrictionMemory::kUnknown};
};

/// A force of friction and the velocity that goes with it.
struct FrictionForce {
  double force = 0.0;     ///< mean of the step [N], against the velocity
  double velocity = 0.0;  ///< of sliding, mean of the step [m/s]; 0: it holds
  double after = 0.0;     ///< at the end of the step; 0: it holds from then on
  FrictionMemory memory = {};
};

/// [realtime] The friction of a step:  mean + mobility F = free,  where at each instant
///   F = normal mu(|v|) sgn v + viscous v,   or v = 0 with |F| <= normal mu(0).
/// The law is solved within the step:
///  - What held breaks away where the force that it would need, on a line from the step before to this one,
///    passes what it can hold with; from there on it slides. What its force has been too large by in the
///    step before is taken off this one and, as no friction pushes on, off the next ones.
///  - Where driven points change their speeds by more than it could hold against, it slides from there on.
///  - What slides goes on, of two ways at the higher speed (the stable one), if it does so until the end.
///  - What would turn round stops. It stays if it can be held; else it slides the other way for the rest.
/// So no motion is turned round but by the other forces, and over a slide friction only takes energy: what
/// the mean force of a stop gives is part of what the slide has lost before, never more.
/// Where both holding and sliding would do, what was so before stays so (McIntyre, Schumacher & Woodhouse,
/// JASA 74, 1983).
FrictionForce solve_friction(const FrictionLaw& law, double viscous, FrictionStep step) noexcept;

/// [realtime] The first step of a network, for half of which it is there: `start` is the velocity at its
/// middle. `step.memory.heat` is what the network lacks in the step before its start: all that the friction
/// may give.
FrictionForce start_friction(const FrictionLaw& law, double viscous, const FrictionStep& step,
                             double start) noexcept;

}  // namespace tactus
