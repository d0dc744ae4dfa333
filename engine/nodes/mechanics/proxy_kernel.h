#pragma once

// Thread: [realtime].

#include "engine/nodes/mechanics/solid_kernel.h"
#include "engine/nodes/mechanics/vector_kernel.h"

// Contact of a point with a solid: a proxy (god object) stays on the surface, as near to the device as
// friction lets it, and a spring pulls the device to the proxy. Since the proxy remembers on which side it
// is, a device does not fall through a thin wall. Zilles & Salisbury, A constraint-based god-object method,
// IROS 1995; friction cone: Ruspini, Kolarov & Khatib, The haptic display of complex graphical environments,
// SIGGRAPH 1997. Places in m, relative to the centre of the solid.

typedef struct tactus_proxy {
  tactus_real at[3];
  int side;     ///< 0: not in touch; 1: in touch; of a box the side that is touched, 1 to 6
  int started;  ///< `at` is a place where the device has been
  int slips;
} tactus_proxy;

typedef struct tactus_proxy_force {
  tactus_real force[3], depth;
} tactus_proxy_force;

/// Whether the proxy lets the device go.
static inline int tactus_proxy_leaves(const tactus_proxy* s, const tactus_solid* solid,
                                      const tactus_real* device, tactus_real depth) {
  const int axis = (s->side - 1) / 2;
  int side, beyond = 0;
  if (solid->shape == TACTUS_SOLID_HEIGHTS) return tactus_solid_outside(solid, device, &side) >= 0;
  for (int i = 0; solid->shape == TACTUS_SOLID_BOX && i < 3; ++i)
    beyond |= i != axis && fabs(s->at[i]) > solid->size[i];
  return beyond || depth <= 0;
}

/// Draws the proxy along the surface towards the device, until it is the nearest place, or held by friction.
static inline tactus_real tactus_proxy_slide(tactus_proxy* s, const tactus_solid* solid,
                                             const tactus_real* device, tactus_real friction) {
  const tactus_real rounding = 1e-14;
  tactus_real depth = 0;
  for (int pass = 0; pass < 4; ++pass) {
    tactus_real normal[3], pull[3], along[3], next[3], length, slip, distance;
    tactus_solid_normal(solid, s->side, s->at, normal);
    for (int i = 0; i < 3; ++i) pull[i] = device[i] - s->at[i];
    depth = -tactus_dot(pull, normal);
    for (int i = 0; i < 3; ++i) along[i] = pull[i] + depth * normal[i];
    length = sqrt(tactus_dot(along, along));
    slip = length - friction * tactus_max(0.0, depth);
    if (!(slip > rounding * (sqrt(tactus_dot(s->at, s->at)) + fabs(depth)))) return depth;
    s->slips |= pass == 0;
    distance = tactus_dot(pull, pull);
    // A step across a valley would take it farther away: a shorter one does not.
    for (int halved = 0; halved < 8; ++halved, slip *= 0.5) {
      tactus_real left = 0;
      for (int i = 0; i < 3; ++i) next[i] = s->at[i] + along[i] * (slip / length);
      tactus_solid_project(solid, s->side, next);
      for (int i = 0; i < 3; ++i) left += (device[i] - next[i]) * (device[i] - next[i]);
      if (left < distance) break;
      if (halved == 7) return depth;
    }
    for (int i = 0; i < 3; ++i) s->at[i] = next[i];
  }
  return depth;
}

/// One frame: the force on the device, and how deep it is behind the surface.
static inline tactus_proxy_force tactus_proxy_step(tactus_proxy* s, const tactus_solid* solid,
                                                   const tactus_real* device, tactus_real stiffness,
                                                   tactus_real friction) {
  tactus_proxy_force out = {{0, 0, 0}, 0};
  tactus_real way[3], meets;
  int side = 0;
  s->slips = 0;
  if (!s->started) {
    if (tactus_solid_outside(solid, device, &side) < 0) s->side = side;
    for (int i = 0; i < 3; ++i) s->at[i] = device[i];
    if (s->side > 0) tactus_solid_project(solid, s->side, s->at);
    s->started = 1;
  }
  if (s->side == 0) {
    for (int i = 0; i < 3; ++i) way[i] = device[i] - s->at[i];
    meets = tactus_solid_meets(solid, s->at, way, &side);
    if (meets <= 1) {
      s->side = side;
      for (int i = 0; i < 3; ++i) s->at[i] += meets * way[i];
      tactus_solid_project(solid, side, s->at);
    }
  }
  if (s->side > 0) {
    out.depth = tactus_proxy_slide(s, solid, device, tactus_max(0.0, friction));
    if (tactus_proxy_leaves(s, solid, device, out.depth)) s->side = 0;
  }
  if (s->side == 0 || !(out.depth > 0)) out.depth = 0;
  for (int i = 0; i < 3; ++i) {
    if (s->side == 0) s->at[i] = device[i];
    if (out.depth > 0) out.force[i] = tactus_max(0.0, stiffness) * (s->at[i] - device[i]);
  }
  return out;
}
