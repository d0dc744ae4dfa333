#pragma once

// Thread: [any] designs, [realtime] steps.

#include "engine/dsp/delays/taps_kernel.h"
#include "engine/dsp/filters/filter_kernel.h"

#define TACTUS_STRING_TAPS 7  ///< six of the interpolator; the one-zero filter is folded in and adds one

/// A waveguide string, one loop of delay N and losses:
///
///   y[n] = x[n] + g (h_LP * y)[n - N]
///   H_LP(z) = (1 - loss/2) + loss/2 z^-1        one zero
///   H_LP(z) = (1 - loss) / (1 - loss z^-1)      one pole
///
/// N is read between samples by Lagrange interpolation of order 5, and is chosen so that the phase once
/// around the loop is exactly a whole turn at the pitch f0 (w = 2 pi f0 / fs):
///
///   N = fs/f0 + arg H_LP(w) / w - the interpolator's own phase error at w
///
/// So a sustained tone sits at f0. A free decay differs by what its damping does to the phase of H_LP: at 4
/// kHz and 48 kHz 0.3 cents for g = 0.9 and a zero with loss 0.5, 1.1 cents for a pole with loss 0.3 (they
/// die within 30 ms), less below and for what dies more slowly. The interpolator's gain is below 1 at high
/// frequencies, a loss that grows with the pitch. Stable for all parameters: g |H_LP| |interpolator| < 1.
/// Partial at w: T60 = 3 ln(10) / (-ln(g |H_LP(w)|)) * N / fs. Source: Jaffe & Smith, "Extensions of the
/// Karplus-Strong plucked-string algorithm", CMJ 7(2), 1983.
typedef struct tactus_string_design {
  int newest;                            ///< frames back of the first tap
  tactus_real taps[TACTUS_STRING_TAPS];  ///< with the loss filter's zeros, and the gain
  tactus_real pole;
} tactus_string_design;

/// What surrounds the line: whether the losses are a pole, the largest gain (1 where the string is not itself
/// a loop), and the frames that the rest of its loop takes.
typedef struct tactus_string_kind {
  int one_pole;
  tactus_real most_gain, frames_outside;
} tactus_string_kind;

typedef struct tactus_complex {
  tactus_real re, im;
} tactus_complex;

static inline tactus_complex tactus_times(tactus_complex a, tactus_complex b) {
  const tactus_complex product = {a.re * b.re - a.im * b.im, a.re * b.im + a.im * b.re};
  return product;
}

/// Smith's way: scaled by the larger part of the divisor.
static inline tactus_complex tactus_divided(tactus_complex a, tactus_complex b) {
  const int steep = fabs(b.re) < fabs(b.im);
  const tactus_real ratio = steep ? b.re / b.im : b.im / b.re;
  const tactus_real below = steep ? b.re * ratio + b.im : b.im * ratio + b.re;
  tactus_complex quotient;
  quotient.re = (steep ? a.re * ratio + a.im : a.im * ratio + a.re) / below;
  quotient.im = (steep ? a.im * ratio - a.re : a.im - a.re * ratio) / below;
  return quotient;
}

static inline tactus_complex tactus_polynomial(const tactus_real* coefficients, int count, tactus_complex x) {
  tactus_complex sum = {0, 0};
  while (count-- > 0) {
    sum = tactus_times(sum, x);
    sum.re += coefficients[count];
  }
  return sum;
}

static inline tactus_complex tactus_turned(tactus_real radians) {
  const tactus_complex turned = {cos(radians), sin(radians)};
  return turned;
}

/// NaN becomes `low`.
static inline tactus_real tactus_within(tactus_real x, tactus_real low, tactus_real high) {
  return x > low ? tactus_min(x, high) : low;
}

/// The interpolator `wanted` frames behind the newest tap, without its own phase error at the pitch.
static inline void tactus_string_weights(tactus_real* weights, tactus_complex delay, tactus_real radians,
                                         tactus_real wanted) {
  tactus_complex error;
  tactus_lagrange(weights, 6, wanted);
  error = tactus_times(tactus_polynomial(weights, 6, delay), tactus_turned(radians * wanted));
  tactus_lagrange(weights, 6, wanted + atan2(error.im, error.re) / radians);
}

/// Out of range is clamped: pitch to [10 Hz, 0.3 fs], gain to [0, most_gain], loss to [0, 1] (one zero) or
/// [0, 0.99] (one pole).
static inline tactus_string_design tactus_string(tactus_string_kind kind, tactus_real pitch, tactus_real gain,
                                                 tactus_real loss, tactus_real rate) {
  const tactus_real frequency = tactus_within(pitch, 10, 0.3 * rate);
  const tactus_real radians = 6.283185307179586 * frequency / rate;
  const tactus_complex delay = tactus_turned(-radians);
  tactus_string_design design = {0, {0, 0, 0, 0, 0, 0, 0}, 0};
  tactus_real zeros[2] = {0, 0}, weights[6], frames;
  tactus_complex losses, poles;
  gain = tactus_within(gain, 0, kind.most_gain);
  loss = tactus_within(loss, 0, kind.one_pole ? 0.99 : 1.0);
  zeros[0] = kind.one_pole ? 1 - loss : 1 - loss / 2;
  zeros[1] = kind.one_pole ? 0 : loss / 2;
  design.pole = kind.one_pole ? loss : 0;
  poles.re = 1 - design.pole * delay.re;
  poles.im = -(design.pole * delay.im);
  losses = tactus_divided(tactus_polynomial(zeros, 2, delay), poles);

  // The middle interval of six taps starts two frames behind the newest, which itself must be in the past.
  frames = tactus_max(3.0, rate / frequency + atan2(losses.im, losses.re) / radians - kind.frames_outside);
  design.newest = (int)frames - 2;
  tactus_string_weights(weights, delay, radians, frames - design.newest);
  for (int k = 0; k < 6; ++k) {
    design.taps[k] += gain * zeros[0] * weights[k];
    design.taps[k + 1] += gain * zeros[1] * weights[k];
  }
  return design;
}

/// The loss that is a pole: set with each design, at the start of a group of eight frames.
static inline void tactus_string_set_pole(tactus_filter* pole, const tactus_string_design* design) {
  tactus_filter_set(pole, tactus_filter_order_1(1, 0, design->pole));
}

/// One frame of the loop. `line`: the past outputs; `pole`: the filter of a loss with a pole, unused if the
/// loss is a zero; `position`: frame number modulo 8.
static inline tactus_real tactus_string_step(const tactus_string_design* design, int one_pole,
                                             tactus_line* line, tactus_filter* pole, tactus_real in,
                                             int position) {
  const tactus_real* newest = tactus_line_tap(line, design->newest, TACTUS_STRING_TAPS - 1);
  tactus_real out = tactus_tap_sum(newest, design->taps, TACTUS_STRING_TAPS, one_pole ? 0 : in);
  if (one_pole) out = in + tactus_filter_step(pole, 1, out, position);
  tactus_line_write(line, out);
  return out;
}

#define TACTUS_WAVEGUIDE_PORT 1.0  ///< frames that what the line hangs on takes to answer

/// A string or a rod seen from one end: waves of force go in, travel to the far end and come back.
///
///   out[n] = +-(h * in)[n - (N - 1)]      + from a fixed end, - from a free one
///
/// h is the gain and the loss of a string (see tactus_string_design) and N its delay, read between samples.
/// So much is left to what the line hangs on, a network's port, so that both together, N frames around, are
/// in tune: with a rigid near end the line sounds at the pitch (fixed), or at odd multiples of half the pitch
/// (free). It reflects at most `gain`, up to 1: |out / in| = gain |H_LP| |interpolator| <= 1 at every
/// frequency, as long as pitch and loss rest. Between in and out lie `least` to `most` frames for all
/// parameters. Source: J. O. Smith, Physical Audio Signal Processing, W3K, 2010.
typedef struct tactus_waveguide {
  tactus_string_kind kind;
  tactus_real sign, rate, lowest, highest;  ///< pitches
  int least, most;                          ///< frames
} tactus_waveguide;

/// Its pitch is clamped to [lowest, highest], and these to [10 Hz, 0.2 rate].
static inline tactus_waveguide tactus_waveguide_between(tactus_real lowest, tactus_real highest, int one_pole,
                                                        int fixed_end, tactus_real rate) {
  const tactus_real top = 0.2 * rate;
  tactus_waveguide s = {{one_pole, 1, TACTUS_WAVEGUIDE_PORT}, fixed_end ? 1.0 : -1.0, rate, 0, 0, 0, 0};
  s.lowest = tactus_clamp(lowest, 10.0, top);
  s.highest = tactus_clamp(highest, s.lowest, top);
  // A loss takes time as well: the darkest leaves the shortest delay.
  s.least = tactus_string(s.kind, s.highest, 1, 1, rate).newest;
  s.most = tactus_string(s.kind, s.lowest, 1, 0, rate).newest;
  return s;
}

static inline tactus_string_design tactus_waveguide_design(const tactus_waveguide* s, tactus_real pitch,
                                                           tactus_real gain, tactus_real loss) {
  tactus_string_design design =
      tactus_string(s->kind, tactus_within(pitch, s->lowest, s->highest), gain, loss, s->rate);
  if (design.newest < s->least) design.newest = s->least;
  if (design.newest > s->most) design.newest = s->most;
  for (int k = 0; k < TACTUS_STRING_TAPS; ++k) design.taps[k] *= s->sign;
  return design;
}

/// A frame: see tactus_string_step, but for what `line` holds: what went in.
static inline tactus_real tactus_waveguide_step(const tactus_string_design* design, int one_pole,
                                                tactus_line* line, tactus_filter* pole, tactus_real in,
                                                int position) {
  const tactus_real* newest;
  tactus_real out;
  tactus_line_write(line, in);
  newest = tactus_line_tap(line, design->newest + 1, TACTUS_STRING_TAPS - 1);
  out = tactus_tap_sum(newest, design->taps, TACTUS_STRING_TAPS, 0);
  return one_pole ? tactus_filter_step(pole, 1, out, position) : out;
}
