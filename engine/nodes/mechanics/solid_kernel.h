#pragma once

// Thread: [realtime].

#include "engine/dsp/kernel.h"
#include "engine/nodes/mechanics/vector_kernel.h"

// Solids: where their surface is, and which way it faces. Places in m, relative to the centre of the solid.

typedef enum tactus_solid_shape {
  TACTUS_SOLID_PLANE,   ///< all that lies behind a plane
  TACTUS_SOLID_SPHERE,  ///< of radius size[0]
  TACTUS_SOLID_BOX,     ///< of half the sides `size`
  TACTUS_SOLID_HEIGHTS  ///< all that lies below z = h(x, y)
} tactus_solid_shape;

#define TACTUS_SOLID_SMALLEST 1e-6  ///< radius, half sides, pitch [m]

typedef struct tactus_solid {
  tactus_solid_shape shape;
  tactus_real normal[3];       ///< of a plane, of length 1; else z
  tactus_real size[3];         ///< of a sphere, of a box; size[0]: pitch of heights
  const tactus_real* heights;  ///< row by row, rows in y
  int rows, columns;
} tactus_solid;

/// Height and slopes between the points of a grid about the centre; level beyond its edges.
static inline tactus_real tactus_height(const tactus_solid* solid, tactus_real x, tactus_real y,
                                        tactus_real slope[2]) {
  const tactus_real pitch = solid->size[0];
  const int last[2] = {solid->columns - 1, solid->rows - 1};
  const tactus_real at[2] = {x / pitch + 0.5 * last[0], y / pitch + 0.5 * last[1]};
  tactus_real part[2], low, high, low_slope, high_slope;
  int cell[2], next[2], inside[2];
  const tactus_real* h = solid->heights;
  for (int i = 0; i < 2; ++i) {
    const tactus_real place = at[i] > 0 ? tactus_min(at[i], (tactus_real)last[i]) : 0;  // of no number 0
    cell[i] = (int)place;
    if (cell[i] > 0 && cell[i] == last[i]) --cell[i];
    next[i] = cell[i] < last[i] ? cell[i] + 1 : cell[i];
    part[i] = place - cell[i];
    inside[i] = at[i] > 0 && at[i] < last[i];
  }
  low = h[cell[1] * solid->columns + cell[0]];
  low_slope = h[cell[1] * solid->columns + next[0]] - low;
  low += part[0] * low_slope;
  high = h[next[1] * solid->columns + cell[0]];
  high_slope = h[next[1] * solid->columns + next[0]] - high;
  high += part[0] * high_slope;
  slope[0] = inside[0] ? (low_slope + part[1] * (high_slope - low_slope)) / pitch : 0;
  slope[1] = inside[1] ? (high - low) / pitch : 0;
  return low + part[1] * (high - low);
}

/// Numbers of a solid in the order of the ports: the direction of a plane, sizes, the pitch of heights.
static inline tactus_solid tactus_solid_of(tactus_solid_shape shape, const tactus_real* numbers,
                                           const tactus_real* heights, int rows, int columns) {
  tactus_solid solid;
  const tactus_real length = sqrt(tactus_dot(numbers, numbers));
  solid.shape = shape;
  solid.heights = heights;
  solid.rows = rows;
  solid.columns = columns;
  for (int i = 0; i < 3; ++i) {
    solid.normal[i] = shape == TACTUS_SOLID_PLANE && length > 0 ? numbers[i] / length : i == 2;
    solid.size[i] = tactus_max(TACTUS_SOLID_SMALLEST, numbers[3 + i]);
  }
  if (shape == TACTUS_SOLID_HEIGHTS) solid.size[0] = tactus_max(TACTUS_SOLID_SMALLEST, numbers[6]);
  return solid;
}

/// The outward direction at a place of the surface.
static inline void tactus_solid_normal(const tactus_solid* solid, int side, const tactus_real* at,
                                       tactus_real* normal) {
  const int axis = (side - 1) / 2;
  tactus_real slope[2], length;
  for (int i = 0; i < 3; ++i) normal[i] = solid->normal[i];
  if (solid->shape == TACTUS_SOLID_PLANE) return;
  if (solid->shape == TACTUS_SOLID_BOX) {
    for (int i = 0; i < 3; ++i) normal[i] = i == axis ? (side % 2 == 1 ? 1 : -1) : 0;
    return;
  }
  if (solid->shape == TACTUS_SOLID_SPHERE) {
    for (int i = 0; i < 3; ++i) normal[i] = at[i];
  } else {
    (void)tactus_height(solid, at[0], at[1], slope);
    normal[0] = -slope[0];
    normal[1] = -slope[1];
    normal[2] = 1;
  }
  length = sqrt(tactus_dot(normal, normal));
  for (int i = 0; i < 3; ++i) normal[i] = length > 0 ? normal[i] / length : solid->normal[i];
}

/// Onto the surface, from a place near it.
static inline void tactus_solid_project(const tactus_solid* solid, int side, tactus_real* at) {
  const int axis = (side - 1) / 2;
  tactus_real slope[2], factor;
  switch (solid->shape) {
    case TACTUS_SOLID_PLANE:
      factor = tactus_dot(at, solid->normal);
      for (int i = 0; i < 3; ++i) at[i] -= factor * solid->normal[i];
      break;
    case TACTUS_SOLID_SPHERE:
      factor = sqrt(tactus_dot(at, at));
      for (int i = 0; i < 3; ++i) at[i] = solid->size[0] * (factor > 0 ? at[i] / factor : solid->normal[i]);
      break;
    case TACTUS_SOLID_BOX:
      at[axis] = side % 2 == 1 ? solid->size[axis] : -solid->size[axis];
      break;
    case TACTUS_SOLID_HEIGHTS:
      at[2] = tactus_height(solid, at[0], at[1], slope);
      break;
  }
}

/// How far a place is outside, in some measure that is 0 on the surface; of a box outside of its nearest
/// side.
static inline tactus_real tactus_solid_outside(const tactus_solid* solid, const tactus_real* at, int* side) {
  tactus_real slope[2], farthest = 0;
  *side = 1;
  switch (solid->shape) {
    case TACTUS_SOLID_PLANE:
      return tactus_dot(at, solid->normal);
    case TACTUS_SOLID_SPHERE:
      return sqrt(tactus_dot(at, at)) - solid->size[0];
    case TACTUS_SOLID_HEIGHTS:
      return at[2] - tactus_height(solid, at[0], at[1], slope);
    case TACTUS_SOLID_BOX:
      for (int i = 0; i < 3; ++i) {
        const tactus_real outside = fabs(at[i]) - solid->size[i];
        if (i > 0 && outside <= farthest) continue;
        farthest = outside;
        *side = 2 * i + (at[i] >= 0 ? 1 : 2);
      }
      break;
  }
  return farthest;
}

/// Where a straight way from a place outside first meets the solid, from 0 to 1; above 1: nowhere.
static inline tactus_real tactus_solid_meets(const tactus_solid* solid, const tactus_real* from,
                                             const tactus_real* way, int* side) {
  const tactus_real nowhere = 2;
  tactus_real there[3], enters = 0, leaves = 1, a, b, c;
  int last;
  *side = 1;
  if (solid->shape == TACTUS_SOLID_SPHERE) {
    a = tactus_dot(way, way);
    b = tactus_dot(from, way);
    c = tactus_dot(from, from) - solid->size[0] * solid->size[0];
    if (!(b < 0) || b * b < a * c) return nowhere;
    return tactus_max(0.0, (-b - sqrt(b * b - a * c)) / a);
  }
  if (solid->shape == TACTUS_SOLID_BOX) {
    *side = 0;
    for (int i = 0; i < 3; ++i) {
      const int up = way[i] < 0;  // it comes from above
      const tactus_real near_side = up ? solid->size[i] : -solid->size[i];
      if (way[i] == 0 && fabs(from[i]) >= solid->size[i]) return nowhere;
      if (way[i] == 0) continue;
      a = (near_side - from[i]) / way[i];
      leaves = tactus_min(leaves, (-near_side - from[i]) / way[i]);
      if (a < enters) continue;
      enters = a;
      *side = 2 * i + (up ? 1 : 2);
    }
    return *side != 0 && enters < leaves ? enters : nowhere;
  }
  for (int i = 0; i < 3; ++i) there[i] = from[i] + way[i];
  a = tactus_solid_outside(solid, from, &last);
  b = tactus_solid_outside(solid, there, &last);
  return b < 0 ? tactus_max(0.0, a / (a - b)) : nowhere;
}
