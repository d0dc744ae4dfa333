#pragma once

// Thread: [realtime].

#include "engine/dsp/kernel.h"

/// The multiple of `step` nearest to `value` (halves go to the even multiple). step <= 0: no
/// rounding. Where value / step overflows, the step is below the resolution of the value.
static inline tactus_real tactus_quantise_nearest(tactus_real value, tactus_real step) {
  const tactus_real steps = step > 0 ? rint(value / step) : HUGE_VAL;
  return tactus_is_finite(steps) ? steps * step : value;
}

/// The largest multiple of `step` that is not above `value`. step <= 0: no rounding.
static inline tactus_real tactus_quantise_floor(tactus_real value, tactus_real step) {
  const tactus_real steps = step > 0 ? floor(value / step) : HUGE_VAL;
  return tactus_is_finite(steps) ? steps * step : value;
}

/// Cubic through `b` (at = 0) and `c` (at = 1) with the slopes (c - a) / 2 and (d - b) / 2;
/// continuous in value and slope from one interval to the next, and exact for parabolas. Catmull & Rom, "A
/// class of local interpolating splines", 1974.
static inline tactus_real tactus_catmull_rom(tactus_real a, tactus_real b, tactus_real c, tactus_real d,
                                             tactus_real at) {
  const tactus_real slope_b = 0.5 * (c - a);
  const tactus_real slope_c = 0.5 * (d - b);
  const tactus_real cubic = slope_b + slope_c - 2.0 * (c - b);
  const tactus_real square = (c - b) - slope_b - cubic;
  return ((cubic * at + square) * at + slope_b) * at + b;
}

/// A function given by `count` points, x not descending; `slope` only where it is cubic.
typedef struct tactus_curve {
  int count;
  const tactus_real *x, *y, *slope;
} tactus_curve;

typedef enum tactus_curve_shape {
  TACTUS_CURVE_LINEAR,
  TACTUS_CURVE_STEP,         ///< holds each value up to the next point
  TACTUS_CURVE_EXPONENTIAL,  ///< moves by equal factors; values of one sign
  TACTUS_CURVE_CUBIC         ///< given by values and slopes
} tactus_curve_shape;

/// The interval between points i and i + 1 that holds a place, and how far in it that lies, in [0, 1].
typedef struct tactus_curve_place {
  int i;
  tactus_real width, at;
} tactus_curve_place;

static inline tactus_curve_place tactus_curve_at(const tactus_curve* c, tactus_real x) {
  int low = 1, high = c->count - 1;  // the first point behind x lies in between
  tactus_curve_place place;
  while (low < high) {
    const int middle = low + (high - low) / 2;
    if (x < c->x[middle])
      high = middle;
    else
      low = middle + 1;
  }
  place.i = low - 1;
  place.width = c->x[low] - c->x[low - 1];
  place.at = (x - c->x[low - 1]) / place.width;
  return place;
}

/// Value of the cubic in an interval.
static inline tactus_real tactus_cubic_value(const tactus_curve* c, tactus_curve_place p) {
  const tactus_real h = p.width, t = p.at, m0 = c->slope[p.i], m1 = c->slope[p.i + 1];
  const tactus_real rise = c->y[p.i + 1] - c->y[p.i];
  const tactus_real cubic = h * (m0 + m1) - 2 * rise;
  const tactus_real square = rise - h * m0 - cubic;
  return ((cubic * t + square) * t + h * m0) * t + c->y[p.i];
}

/// The cubic and its first two derivatives; level outside the points.
typedef struct tactus_cubic_point {
  tactus_real value, slope, curvature;
} tactus_cubic_point;

static inline tactus_cubic_point tactus_cubic_at(const tactus_curve* c, tactus_real x) {
  tactus_cubic_point point = {0, 0, 0};
  tactus_curve_place p;
  tactus_real rise, cubic, square;
  if (!(x > c->x[0] && x < c->x[c->count - 1])) {
    point.value = x > c->x[0] ? c->y[c->count - 1] : c->y[0];
    return point;
  }
  p = tactus_curve_at(c, x);
  rise = c->y[p.i + 1] - c->y[p.i];
  cubic = c->slope[p.i] + c->slope[p.i + 1] - 2 * rise / p.width;
  square = rise / p.width - c->slope[p.i] - cubic;
  point.value = tactus_cubic_value(c, p);
  point.slope = (3 * cubic * p.at + 2 * square) * p.at + c->slope[p.i];
  point.curvature = (6 * cubic * p.at + 2 * square) / p.width;
  return point;
}

/// Moves by equal factors from one value to another of the same sign, at in [0, 1].
static inline tactus_real tactus_geometric(tactus_real from, tactus_real to, tactus_real at) {
  const tactus_real ratio = to / from;
  if (ratio != 0 && tactus_is_finite(ratio)) return from * pow(ratio, at);
  // Beyond what a double holds: in two steps, through their mean.
  return at < 0.5 ? from * pow(sqrt(fabs(to)) / sqrt(fabs(from)), 2 * at)
                  : to * pow(sqrt(fabs(from)) / sqrt(fabs(to)), 2 * (1 - at));
}

/// Held at the end values outside the points. Two points at one x are a jump: there the later one counts.
static inline int tactus_curve_outside(const tactus_curve* c, tactus_real x) {
  return !(x >= c->x[0] && x < c->x[c->count - 1]);
}
static inline tactus_real tactus_curve_value(const tactus_curve* c, tactus_curve_shape shape, tactus_real x) {
  tactus_curve_place place;
  tactus_real from, to;
  if (tactus_curve_outside(c, x)) return x < c->x[0] ? c->y[0] : c->y[c->count - 1];
  place = tactus_curve_at(c, x);
  from = c->y[place.i];
  to = c->y[place.i + 1];
  switch (shape) {
    case TACTUS_CURVE_STEP:
      return from;
    case TACTUS_CURVE_EXPONENTIAL:
      return tactus_geometric(from, to, place.at);
    case TACTUS_CURVE_CUBIC:
      return tactus_cubic_value(c, place);
    default:
      return from + place.at * (to - from);
  }
}

/// d value / d x; at a point, that of the interval to its right.
static inline tactus_real tactus_curve_slope(const tactus_curve* c, tactus_curve_shape shape, tactus_real x) {
  tactus_curve_place place;
  tactus_real from, to;
  if (tactus_curve_outside(c, x) || shape == TACTUS_CURVE_STEP) return 0;
  place = tactus_curve_at(c, x);
  from = c->y[place.i];
  to = c->y[place.i + 1];
  switch (shape) {
    case TACTUS_CURVE_EXPONENTIAL:
      return tactus_geometric(from, to, place.at) * (log(fabs(to)) - log(fabs(from))) / place.width;
    case TACTUS_CURVE_CUBIC:
      return tactus_cubic_at(c, x).slope;
    default:
      return (to - from) / place.width;
  }
}
