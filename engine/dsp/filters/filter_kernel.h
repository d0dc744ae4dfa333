#pragma once

#include "engine/dsp/kernel.h"

// Thread: [any] designs, [realtime] steps.

/// y[n] = b0 x[n] + b1 x[n-1] + b2 x[n-2] + a1 y[n-1] + a2 y[n-2].   Mind the sign of a.
/// Of order 1, b2 and a2 are not used.
typedef struct tactus_filter_design {
  int order;
  tactus_real b[3], a[2];
} tactus_filter_design;

static inline tactus_filter_design tactus_filter_order_1(tactus_real b0, tactus_real b1, tactus_real a1) {
  const tactus_filter_design design = {1, {b0, b1, 0}, {a1, 0}};
  return design;
}

/// A cutoff that any filter can be designed for: (0, 0.49] of the rate, NaN included. As radians per frame.
static inline tactus_real tactus_filter_radians(tactus_real hertz, tactus_real rate) {
  const tactus_real turns = hertz / rate;
  return 6.283185307179586 * (turns > 1e-6 ? tactus_min(turns, 0.49) : 1e-6);
}

/// A q that any filter can be designed for: [0.01, 1000], NaN included.
static inline tactus_real tactus_filter_q(tactus_real q) { return q > 0.01 ? tactus_min(q, 1000.0) : 0.01; }

/// One pole, by the bilinear transform prewarped at the cutoff w = 2 pi fc / fs: exactly -3.01 dB and -45
/// degrees there at every rate, gain 1 at 0 Hz, 0 at half the rate. With p = (1 - tan(w/2)) / (1 + tan(w/2)):
///
///   H(z) = (1 - p)/2 (1 + z^-1) / (1 - p z^-1)          and 1 - H is the high-pass with the same cutoff.
///
/// Source: Oppenheim & Schafer, Discrete-Time Signal Processing, 7.1.2.
static inline tactus_filter_design tactus_one_pole(tactus_real radians) {
  const tactus_real t = tan(radians / 2);
  const tactus_real gain = t / (1 + t);  // (1 - p) / 2 without the cancellation
  return tactus_filter_order_1(gain, gain, (1 - t) / (1 + t));
}

/// The pole p of H(z) = (1 - p) / (1 - p z^-1) that is exactly -3.01 dB at the cutoff:
///
///   p^2 - 2 c p + 1 = 0,  c = 2 - cos w,  so 1 - p = sqrt(c^2 - 1) - (c - 1)
///
/// It lags half a frame less than the bilinear one and passes a little at half the rate: the choice for a
/// filter in a control loop. Returns 1 - p, which small cutoffs do not cancel.
static inline tactus_real tactus_matched_one_pole_gain(tactus_real radians) {
  const tactus_real s = sin(radians / 2);
  const tactus_real c_minus_1 = 2 * s * s;
  return sqrt(c_minus_1 * (c_minus_1 + 2)) - c_minus_1;
}

/// y = (1 - p) x + p y1 with that pole.
static inline tactus_filter_design tactus_matched_one_pole(tactus_real radians) {
  const tactus_real gain = tactus_matched_one_pole_gain(radians);
  return tactus_filter_order_1(gain, 0, 1 - gain);
}

/// y = p (y1 + x - x1), p = 1 / (1 + 2 pi fc / fs): an RC high-pass by backward Euler, as audio inputs have
/// one. -3.01 dB at the cutoff for fc << fs (within 1 % of it below fs / 600).
static inline tactus_filter_design tactus_dc_blocker(tactus_real radians) {
  const tactus_real p = 1 / (1 + radians);
  return tactus_filter_order_1(p, -p, p);
}

/// A difference in units per second, then the matched one-pole: the velocity of a position. A ramp of slope
/// 1/s comes out as exactly 1.
static inline tactus_filter_design tactus_filtered_velocity(tactus_real radians, tactus_real rate) {
  const tactus_real gain = tactus_matched_one_pole_gain(radians);
  return tactus_filter_order_1(gain * rate, -gain * rate, 1 - gain);
}

/// Filters of order 2 after R. Bristow-Johnson, "Cookbook formulae for audio EQ biquad filter coefficients":
/// bilinear, prewarped at w = 2 pi f / fs [radians per frame], alpha = sin w / (2 q). At w a low-pass or
/// high-pass has gain q (-3.01 dB for q = 1/sqrt 2: Butterworth), a band-pass has gain 1. Valid for 0 < w <
/// pi, q > 0. Coefficients are exact to a few roundings; the poles of a filter with a very low cutoff are
/// not: expect a gain at 0 Hz within 2e-16 / w^2.
static inline tactus_filter_design tactus_biquad(tactus_real radians, tactus_real alpha, tactus_real b0,
                                                 tactus_real b1, tactus_real b2) {
  const tactus_real scale = 1 / (1 + alpha);
  const tactus_real first = b0 * scale;
  // The same rounding for both ends and the middle keeps a zero at 0 Hz exactly there.
  const tactus_filter_design design = {2,
                                       {first, b0 != 0 ? first * (b1 / b0) : 0, first * (b2 / b0)},
                                       {2 * cos(radians) * scale, (alpha - 1) * scale}};
  return design;
}
static inline tactus_filter_design tactus_low_pass(tactus_real radians, tactus_real q) {
  const tactus_real one_minus_cos = 2 * sin(radians / 2) * sin(radians / 2);
  return tactus_biquad(radians, sin(radians) / (2 * q), one_minus_cos / 2, one_minus_cos, one_minus_cos / 2);
}
static inline tactus_filter_design tactus_high_pass(tactus_real radians, tactus_real q) {
  const tactus_real one_plus_cos = 1 + cos(radians);
  return tactus_biquad(radians, sin(radians) / (2 * q), one_plus_cos / 2, -one_plus_cos, one_plus_cos / 2);
}
/// Peak gain 1; q = f / bandwidth (to -3.01 dB, before the warping of the frequency axis).
static inline tactus_filter_design tactus_band_pass(tactus_real radians, tactus_real q) {
  const tactus_real alpha = sin(radians) / (2 * q);
  return tactus_biquad(radians, alpha, alpha, 0, -alpha);
}

/// Such a filter in direct form I, frame by frame, with the operations of the vectorised Recurrence
/// (recurrence.h), whose groups of eight frames lie on the absolute frame grid: the same bits.
typedef struct tactus_filter {
  tactus_filter_design design;
  tactus_real h[9];        ///< impulse response of the recurrence
  tactus_real sums[8];     ///< of this group, without the outputs before it
  tactus_real x[2], y[2];  ///< newest first; y: before this group
} tactus_filter;

/// At the start of a group of eight frames only.
static inline void tactus_filter_set(tactus_filter* s, tactus_filter_design design) {
  s->design = design;
  s->h[0] = 1;
  s->h[1] = design.a[0];
  for (int k = 2; k < 9; ++k) {
    s->h[k] = design.a[0] * s->h[k - 1];
    if (design.order == 2) s->h[k] = tactus_fma(design.a[1], s->h[k - 2], s->h[k]);
  }
}

/// `sum` and the response, k frames into the group, to the outputs before the group.
static inline tactus_real tactus_filter_output(const tactus_filter* s, int order, int k, tactus_real sum) {
  if (order == 2) sum = tactus_fma(s->design.a[1] * s->h[k], s->y[1], sum);
  return tactus_fma(s->h[k + 1], s->y[0], sum);
}

/// `order`: that of the design; `position`: frame number modulo 8.
static inline tactus_real tactus_filter_step(tactus_filter* s, int order, tactus_real in, int position) {
  const tactus_real* b = s->design.b;
  // Not fused, so that equal inputs cancel exactly.
  const tactus_real v =
      order == 2 ? (b[0] * in + b[2] * s->x[1]) + b[1] * s->x[0] : b[0] * in + b[1] * s->x[0];
  tactus_real out;
  s->x[1] = s->x[0];
  s->x[0] = in;
  for (int k = 0; k < 8; ++k)
    s->sums[k] = tactus_fma(k < position ? 0.0 : s->h[k - position], v, position == 0 ? 0.0 : s->sums[k]);
  out = tactus_filter_output(s, order, position, s->sums[position]);
  if (position == 7) {
    const tactus_real newest = tactus_filter_output(s, order, 7, s->sums[7]);
    s->y[1] = tactus_filter_output(s, order, 6, s->sums[6]);
    s->y[0] = newest;
  }
  return out + 0.0;
}

/// Backward difference, per second; 0 comes before the first frame.
typedef struct tactus_difference {
  tactus_real before;
} tactus_difference;

static inline tactus_real tactus_difference_step(tactus_difference* s, tactus_real in, tactus_real rate) {
  const tactus_real out = (in - s->before) * rate;
  s->before = in;
  return out;
}

#define TACTUS_FIR_SUMS 8

static inline tactus_real tactus_fir_total(const tactus_real* s) {
  return ((s[0] + s[1]) + (s[2] + s[3])) + ((s[4] + s[5]) + (s[6] + s[7]));
}

/// y[n] = sum over k of taps[k] x[n-k], straight from the definition: no delay of its own, one multiply-add a
/// tap. Eight sums, of every eighth tap each, are added up at the end. `taps`: the last one first, with zeros
/// before it so that `count` is a multiple of eight; `oldest`: the input that the first of them is for, which
/// the others follow.
static inline tactus_real tactus_fir_frame(const tactus_real* taps, int count, const tactus_real* oldest) {
  tactus_real sums[TACTUS_FIR_SUMS] = {0};
  for (int k = 0; k < count; ++k) {
    tactus_real* sum = sums + k % TACTUS_FIR_SUMS;
    *sum = tactus_fma(taps[k], oldest[k], *sum);
  }
  return tactus_fir_total(sums);
}
