#pragma once

// Thread: [any].

#include "engine/dsp/kernel.h"

// The friction of engine/physics/couplings/friction_step.h in C, with the same bits: see there for the
// method.

/// How the coefficient of friction falls with the speed of sliding, and what a lubricant adds:
///   mu(v) = kinetic + sum of drop[i] exp(-|v| / speed[i]),   F = N mu(|v|) sgn v + viscous v
typedef struct tactus_friction_law {
  tactus_real kinetic;
  tactus_real drop[2], speed[2];  ///< speed [m/s], > 0
  tactus_real viscous;            ///< [N s/m]
} tactus_friction_law;

/// At a speed >= 0.
static inline tactus_real tactus_friction_coefficient(const tactus_friction_law* law, tactus_real speed) {
  tactus_real mu = law->kinetic;
  for (int i = 0; i < 2; ++i)
    if (law->drop[i] > 0) mu += law->drop[i] * exp(-speed / law->speed[i]);
  return mu;
}
/// dmu/dv [s/m]
static inline tactus_real tactus_friction_slope(const tactus_friction_law* law, tactus_real speed) {
  tactus_real slope = 0;
  for (int i = 0; i < 2; ++i)
    if (law->drop[i] > 0) slope -= law->drop[i] / law->speed[i] * exp(-speed / law->speed[i]);
  return slope;
}
/// What a friction keeps from step to step, beside the sign of its sliding.
typedef struct tactus_friction_memory {
  tactus_real margin;  ///< what more it could have held with in the last step [N]; -1: unknown, -2: the start
  tactus_real heat;    ///< what it has taken in this slide: force times velocity, summed over its steps [W]
  tactus_real owed;    ///< how much too large its force has been since it began to slide [N steps]
} tactus_friction_memory;

/// A step as a friction meets it: bodies that without it would slide at `free`, and which a force slows by
/// `mobility` [m/s/N]. Both are means over the step, mean = (before + after) / 2. [m/s], [N]
typedef struct tactus_friction_step {
  tactus_real normal, free, mobility;
  tactus_real before;  ///< at the start of the step
  tactus_real jump;    ///< by how much driven points change it: halfway (centred), or at the start
  int holds;           ///< it held in the step before
  int centred;         ///< a body that stops in the step moves on at half its speed, else to where it stops
  int clings;          ///< what cannot hold pushes with all that it can hold with, and does not slide yet
  tactus_friction_memory memory;
} tactus_friction_step;

/// A force of friction and the velocity that goes with it.
typedef struct tactus_friction_force {
  tactus_real force;     ///< mean of the step [N], against the velocity
  tactus_real velocity;  ///< of sliding, mean of the step [m/s]; 0: it holds
  tactus_real after;     ///< at the end of the step; 0: it holds from then on
  tactus_friction_memory memory;
} tactus_friction_force;

/// A step, seen in the direction of `sign`.
typedef struct tactus_rubbing {
  const tactus_friction_law* law;
  const tactus_friction_step* step;
  tactus_real sign, free, before, jump, holding;
} tactus_rubbing;

static inline tactus_rubbing tactus_rubbing_of(const tactus_friction_law* law,
                                               const tactus_friction_step* step, tactus_real sign) {
  tactus_rubbing r;
  r.law = law;
  r.step = step;
  r.sign = sign;
  r.free = sign * step->free;
  r.before = sign * step->before;
  r.jump = sign * step->jump;
  r.holding = step->normal * (law->kinetic + law->drop[0] + law->drop[1]);
  return r;
}

static inline tactus_friction_force tactus_friction_result(tactus_real force, tactus_real velocity,
                                                           tactus_real after, tactus_real margin) {
  tactus_friction_force found;
  found.force = force;
  found.velocity = velocity;
  found.after = after;
  found.memory.margin = margin;
  found.memory.heat = found.memory.owed = 0;
  return found;
}

/// The largest speed v in (0, free] where  v (1 + y c) + y N mu(v) = free;  below 0 if there is none. The
/// left side is convex, so Newton's steps from the right come down to its last root and never pass it.
static inline tactus_real tactus_sliding_speed(const tactus_friction_law* law, tactus_real normal,
                                               tactus_real free, tactus_real mobility) {
  const tactus_real own = 1 + mobility * law->viscous, slowing = mobility * normal;
  tactus_real v = free / own;
  for (int i = 0; i < 60; ++i) {
    const tactus_real excess = v * own + slowing * tactus_friction_coefficient(law, v) - free;
    tactus_real slope, next;
    if (excess <= 0) return v;
    slope = own + slowing * tactus_friction_slope(law, v);
    if (slope <= 0) return -1;
    next = v - excess / slope;
    if (next <= 0) return -1;
    if (v - next <= 1e-15 * v) return next;
    v = next;
  }
  return v;
}

/// The mean speed of what slides in a part of the step.
static inline tactus_real tactus_rubbing_speed(const tactus_rubbing* r, tactus_real free, tactus_real part) {
  return tactus_sliding_speed(r->law, r->step->normal, free, part * r->step->mobility);
}

/// Whether the friction falls so fast with the speed that a part of the step is many times as long as what
/// that takes.
static inline int tactus_rubbing_runs_away(const tactus_rubbing* r, tactus_real v, tactus_real part) {
  return -2 * part * r->step->mobility * r->step->normal * tactus_friction_slope(r->law, v) > 0.5;
}
static inline tactus_real tactus_rubbing_resistance(const tactus_rubbing* r, tactus_real v) {
  return r->step->normal * tactus_friction_coefficient(r->law, v) + r->law->viscous * v;
}

/// The speed at the end of a part of the step under a force on a line, by shorter steps of Runge's method.
static inline tactus_real tactus_rubbing_run_away(const tactus_rubbing* r, tactus_real v, tactus_real from,
                                                  tactus_real to, tactus_real part) {
  const tactus_real y = 2 * part * r->step->mobility;
  const tactus_real steps = tactus_min(32, ceil(-4 * y * r->step->normal * tactus_friction_slope(r->law, v)));
  for (tactus_real i = 0; i < steps; i += 1) {
    const tactus_real force = from + (to - from) * i / steps, middle = force + 0.5 * (to - from) / steps;
    const tactus_real half = tactus_max(0, v + 0.5 * y / steps * (force - tactus_rubbing_resistance(r, v)));
    v = tactus_max(0, v + y / steps * (middle - tactus_rubbing_resistance(r, half)));
  }
  return v;
}

/// The mean velocity of a step, or the nearest one whose force gives no more than `heat`.
static inline tactus_real tactus_with_losses(tactus_real free, tactus_real mean, tactus_real mobility,
                                             tactus_real heat) {
  tactus_real root;
  if (!((free - mean) * mean < -mobility * heat)) return mean;
  root = sqrt(free * free + 4 * mobility * heat);
  return 0.5 * (free + (mean > 0 ? root : -root));
}

/// A force that gives energy gives no more than the slide has lost.
static inline tactus_friction_force tactus_rubbing_move(const tactus_rubbing* r, tactus_real mean,
                                                        tactus_real before) {
  const tactus_real y = r->step->mobility, heat = r->step->memory.heat;
  const tactus_real slower = tactus_with_losses(r->free, mean, y, heat), force = (r->free - slower) / y;
  tactus_friction_force found =
      tactus_friction_result(r->sign * force, r->sign * slower, r->sign * (2 * slower - before), -1);
  found.memory.heat = tactus_max(0, heat + force * slower);
  return found;
}

static inline tactus_friction_force tactus_rubbing_slide(const tactus_rubbing* r, tactus_real v,
                                                         tactus_real before) {
  const tactus_real slower = tactus_min(v, tactus_max(0, r->free));
  tactus_friction_force found = tactus_rubbing_move(r, slower, before);
  found.memory.owed = (v - slower) / r->step->mobility;
  return found;
}

/// The part of the step after which it stops.
static inline tactus_real tactus_rubbing_stopped_after(const tactus_rubbing* r, tactus_real before,
                                                       tactus_real load) {
  return before / (2 * r->step->mobility * (tactus_rubbing_resistance(r, 0.5 * before) - load));
}

/// It slid before, in the direction of `sign`.
static inline tactus_friction_force tactus_rubbing_moving(const tactus_rubbing* r, tactus_real before) {
  const tactus_real y = r->step->mobility, load = (r->free - before) / y;
  const tactus_real driven = load + r->step->memory.owed;
  const tactus_real v = tactus_rubbing_speed(r, r->free + y * r->step->memory.owed, 1);
  tactus_real rest;
  if (v > 0 && 2 * v >= before) {
    const int away = v > before && tactus_rubbing_runs_away(r, before, 1);
    return tactus_rubbing_slide(
        r, away ? 0.5 * (before + tactus_rubbing_run_away(r, before, driven, driven, 1)) : v, before);
  }
  if (fabs(load) <= r->holding) {  // it stops
    const tactus_real part =
        r->step->centred ? 1 : tactus_min(1, tactus_rubbing_stopped_after(r, before, load));
    const tactus_real mean = 0.5 * part * before;
    tactus_friction_force found = tactus_rubbing_move(r, mean, before);
    if (found.velocity == r->sign * mean) found.after = 0;
    return found;
  }
  // A stiff viscous part: the law of the velocity at the end.
  if (load > 0)
    return tactus_rubbing_move(
        r, 0.5 * (before + tactus_max(0, tactus_rubbing_speed(r, 2 * r->free - before, 2))), before);
  rest = 1 - tactus_min(1, tactus_rubbing_stopped_after(r, before, load));
  return tactus_rubbing_move(r, 0.5 * before - tactus_max(0, tactus_rubbing_speed(r, -y * rest * load, rest)),
                             before);
}

/// Driven points change their speeds so much that it slides from there on: either at once, or halfway. Until
/// then it holds, or pushes with all that it can hold with.
static inline tactus_friction_force tactus_rubbing_slip_at_jump(const tactus_rubbing* r, tactus_real load) {
  const tactus_real y = r->step->mobility;
  tactus_real first, start, end, way;
  tactus_friction_step half;
  tactus_rubbing later;
  if (!r->step->centred) {
    way = r->step->jump < 0 ? -1 : 1;
    later = tactus_rubbing_of(r->law, r->step, way);
    return tactus_rubbing_moving(&later, way * r->step->jump);
  }
  first = tactus_max(-r->holding, tactus_min(load, r->holding));
  start = r->jump + y * (load - first);
  end = 2 * r->free - r->before - y * first;
  way = start < 0 ? -1 : 1;
  half.normal = r->step->normal;
  half.free = 0.5 * (start + end);
  half.mobility = 0.5 * y;
  half.before = half.jump = 0;
  half.holds = half.centred = half.clings = 0;
  half.memory.margin = -1;
  half.memory.heat = half.memory.owed = 0;
  later = tactus_rubbing_of(r->law, &half, way);
  return tactus_rubbing_move(
      r, r->free - y * (0.5 * (first + tactus_rubbing_moving(&later, way * start).force)), r->before);
}

static inline tactus_friction_force tactus_rubbing_break_away(const tactus_rubbing* r, tactus_real load,
                                                              tactus_real margin) {
  const tactus_real known = r->step->memory.margin, grown = known - margin;
  const tactus_real part = known < 0 ? 1 : 0.5 - margin / grown;
  const tactus_real drive = known < 0 ? fabs(load) : r->holding + 0.5 * part * grown;
  const tactus_real v = tactus_rubbing_runs_away(r, 0, part)
                            ? 0.5 * tactus_rubbing_run_away(r, 0, known < 0 ? drive : r->holding,
                                                            known < 0 ? drive : 2 * drive - r->holding, part)
                            : tactus_max(0, tactus_rubbing_speed(r, r->step->mobility * part * drive, part));
  // No friction slows it further, however driven points change their speeds.
  return tactus_rubbing_slide(r, tactus_max(v, r->free - r->step->mobility * r->holding), r->before);
}

/// It held before; `sign` is that of the force which it would need.
static inline tactus_friction_force tactus_rubbing_from_rest(const tactus_rubbing* r) {
  const tactus_real y = r->step->mobility, needed = r->free / y;
  const tactus_real load = needed - r->jump * (r->step->centred ? 0.5 : 1) / y;
  const tactus_real margin = r->holding - fabs(load);
  if (needed <= r->holding) {
    const tactus_real mean = r->step->centred ? 0.5 * r->before : 0;
    return tactus_friction_result(r->sign * (r->free - mean) / y, 0, 0, tactus_max(0, margin));
  }
  if (r->step->clings) {
    const tactus_real mean = r->free - y * r->holding;
    return tactus_friction_result(r->sign * r->holding, r->sign * mean, r->sign * (2 * mean - r->before), -1);
  }
  if (margin >= 0 || fabs(r->jump) > y * r->holding) return tactus_rubbing_slip_at_jump(r, load);
  return tactus_rubbing_break_away(r, load, margin);
}

/// The friction of a step:  mean + mobility F = free,  where at each instant
///   F = normal mu(|v|) sgn v + viscous v,   or v = 0 with |F| <= normal mu(0).
static inline tactus_friction_force tactus_friction_solve(const tactus_friction_law* law,
                                                          tactus_friction_step step) {
  tactus_rubbing r;
  step.normal = tactus_max(0, step.normal);
  // Below half a unit in the last place of 1 a viscous part changes no velocity.
  if (step.mobility <= 0 || !(step.normal != 0 || 1 + step.mobility * law->viscous != 1)) {
    const tactus_real v = fabs(step.free);
    const tactus_real force = step.normal * tactus_friction_coefficient(law, v) + law->viscous * v;
    if (step.free == 0 && step.before == 0) return tactus_friction_result(0, 0, 0, -1);
    return tactus_friction_result(signbit(step.free) ? -force : force, step.free, 2 * step.free - step.before,
                                  -1);
  }
  if (step.holds) {
    r = tactus_rubbing_of(law, &step, step.free < 0 ? -1 : 1);
    return tactus_rubbing_from_rest(&r);
  }
  r = tactus_rubbing_of(law, &step, (step.before != 0 ? step.before : step.free) < 0 ? -1 : 1);
  return tactus_rubbing_moving(&r, r.before);
}

/// The first step of a network, for half of which it is there: `start` is the velocity at its middle.
/// `step.memory.heat` is what the network lacks in the step before its start: all that the friction may give.
static inline tactus_friction_force tactus_friction_start(const tactus_friction_law* law,
                                                          tactus_friction_step step, tactus_real start) {
  const tactus_real end = 2 * step.free - step.before, heat = step.memory.heat;
  tactus_friction_step half = step;
  tactus_friction_force found;
  tactus_real mean, slower;
  half.before = start;
  half.free = 0.5 * (start + end);
  half.mobility = 0.5 * step.mobility;
  half.jump = 0;
  half.memory.margin = -1;
  found = tactus_friction_solve(law, half);
  found.force *= 0.5;
  if (step.mobility <= 0 || (step.holds && found.after == 0)) return found;
  // The energy that it gives or takes is that of the whole step, as of all other forces.
  mean = step.free - step.mobility * found.force;
  slower = tactus_with_losses(step.free, mean, step.mobility, heat);
  if (slower != mean) {
    found.force = (step.free - slower) / step.mobility;
    found.velocity = slower;
    found.after = 2 * slower - step.before;
  }
  found.memory.heat = tactus_max(0, heat + found.force * slower);
  return found;
}
