#pragma once

// Thread: [realtime].

#include "engine/dsp/kernel.h"

/// Nonlinear functions f of slope 1 at 0 with values from -1 to 1.
typedef enum tactus_shape {
  TACTUS_SHAPE_TANH,
  TACTUS_SHAPE_SOFT,  ///< x - 4/27 x^3 up to |x| = 1.5
  TACTUS_SHAPE_HARD,
  TACTUS_SHAPE_FOLD  ///< sin x
} tactus_shape;

static inline tactus_real tactus_shape_value(tactus_shape shape, tactus_real x) {
  const tactus_real within = tactus_clamp(x, -1.5, 1.5);
  if (shape == TACTUS_SHAPE_TANH) return tanh(x);
  if (shape == TACTUS_SHAPE_SOFT) return within * (1.0 - 4.0 / 27.0 * within * within);
  if (shape == TACTUS_SHAPE_HARD) return tactus_clamp(x, -1.0, 1.0);
  return sin(x);
}

/// Its integral from 0 to x.
static inline tactus_real tactus_shape_integral(tactus_shape shape, tactus_real x) {
  const tactus_real size = fabs(x), square = x * x;
  if (shape == TACTUS_SHAPE_TANH) return size + log1p(exp(-2.0 * size)) - 0.6931471805599453;
  if (shape == TACTUS_SHAPE_SOFT) return size < 1.5 ? square * (0.5 - square / 27.0) : size - 0.5625;
  if (shape == TACTUS_SHAPE_HARD) return size < 1 ? 0.5 * square : size - 0.5;
  return 1.0 - cos(x);
}

static inline tactus_real tactus_shape_slope(tactus_shape shape, tactus_real x) {
  const tactus_real size = fabs(x);
  if (shape == TACTUS_SHAPE_TANH) return 1.0 - tanh(x) * tanh(x);
  if (shape == TACTUS_SHAPE_SOFT) return size < 1.5 ? 1.0 - 4.0 / 9.0 * x * x : 0.0;
  if (shape == TACTUS_SHAPE_HARD) return size < 1 ? 1.0 : 0.0;
  return cos(x);
}

/// The mean of f on the straight line from the sample before to this one, which suppresses aliases by the
/// sinc of a sample:  y[n] = (F(x[n]) - F(x[n - 1])) / (x[n] - x[n - 1]),  F the integral of f; half a frame
/// late. Source: Parker, Zavalishin & Le Bivic, DAFx 2016; Bilbao et al., IEEE Signal Process. Lett. 24,
/// 2017.
typedef struct tactus_shaper {
  tactus_real last, integral;
} tactus_shaper;

static inline tactus_real tactus_shaper_step(tactus_shaper* s, tactus_real in, tactus_real drive,
                                             tactus_real level, tactus_real shape) {
  const tactus_shape kind = (tactus_shape)(int)shape;
  const tactus_real gain = tactus_max(0.0, drive);
  const tactus_real x = level > 0 ? tactus_clamp(gain * (in / level), -1e9, 1e9) : 0.0;
  const tactus_real before = s->last, change = x - before, integral = tactus_shape_integral(kind, x);
  // Where the difference of the integrals holds too few digits, f in the middle is nearer: its error is
  // change^2 / 24.
  const int near = fabs(change) <= 1e-5 * tactus_max(1.0, kind == TACTUS_SHAPE_FOLD ? 1.0 : fabs(x));
  const tactus_real mean =
      near ? tactus_shape_value(kind, before + 0.5 * change) : (integral - s->integral) / change;
  s->last = x;
  s->integral = integral;
  return tactus_max(0.0, level) * tactus_clamp(mean, -1.0, 1.0);
}
