#pragma once

#include "engine/dsp/kernel.h"

// Thread: [realtime].

/// Weights that read between samples: the polynomial through `taps` taps (2, 4 or 6) at 0, 1 … frames, taken
/// at `t` frames from the newest:
///
///   w[k] = product over j != k of (t - j) / (k - j)
///
/// Exact for polynomials of one order less. In the middle interval (t between taps/2 - 1 and taps/2) the gain
/// is at most 1 at every frequency, which makes it safe in a loop; outside it rises above 1 at high
/// frequencies. Source: Laakso, Valimaki, Karjalainen & Laine, "Splitting the unit delay", IEEE SP Magazine
/// 13, 1996.
static inline void tactus_lagrange(tactus_real* w, int taps, tactus_real t) {
  static const tactus_real two[] = {-1, 1}, four[] = {-6, 2, -2, 6}, six[] = {-120, 24, -12, 12, -24, 120};
  const tactus_real* divisors = taps == 2 ? two : taps == 4 ? four : six;
  tactus_real product = 1;
  for (int k = 0; k < taps; ++k) {
    w[k] = product;
    product *= t - k;
  }
  product = 1;
  for (int k = taps - 1; k >= 0; --k) {
    w[k] *= product / divisors[k];
    product *= t - k;
  }
}

/// A delay in frames. Times that were meant as whole frames ("20 ms") come out a rounding beside them.
static inline tactus_real tactus_delay_frames(tactus_real seconds, tactus_real rate) {
  const tactus_real frames = seconds * rate, whole = rint(frames);
  return fabs(frames - whole) < 1e-9 ? whole : frames;
}

/// Frames back of the newest of order + 1 taps, which is `least` or more: the delay lies in their middle
/// interval where it can. Order 0 is the nearest whole frame.
static inline int tactus_delay_newest(tactus_real frames, int order, int least) {
  const int newest = order == 0 ? (int)(frames + 0.5) : (int)frames - (order - 1) / 2;
  return newest < least ? least : newest;
}

/// The last samples of a signal in a ring of `capacity`, a power of two, zeros at first. The first `mirrored`
/// of them stand behind its end once more, so that so many in a row never wrap.
typedef struct tactus_line {
  tactus_real* samples;  ///< capacity + mirrored
  int capacity, mirrored, next;
} tactus_line;

static inline void tactus_line_write(tactus_line* s, tactus_real x) {
  s->samples[s->next] = x;
  if (s->next < s->mirrored) s->samples[s->capacity + s->next] = x;
  s->next = (s->next + 1) & (s->capacity - 1);
}

/// Points at the sample written `back` ago (1: the last one). `older` samples stand before it, later ones
/// behind it.
static inline const tactus_real* tactus_line_tap(const tactus_line* s, int back, int older) {
  return s->samples + ((s->next - back - older) & (s->capacity - 1)) + older;
}

/// start + sum over k of weight[k] newest[-k] in two chains, even and odd taps, which halves the latency.
static inline tactus_real tactus_tap_sum(const tactus_real* newest, const tactus_real* weight, int taps,
                                         tactus_real start) {
  tactus_real even = tactus_fma(weight[0], newest[0], start), odd = taps > 1 ? weight[1] * newest[-1] : 0;
  for (int k = 2; k < taps; k += 2) even = tactus_fma(weight[k], newest[-k], even);
  for (int k = 3; k < taps; k += 2) odd = tactus_fma(weight[k], newest[-k], odd);
  return even + odd;
}

/// The range of the times of a delay [s]. It is read through `order` + 1 taps: order 0, 1, 3 or 5.
typedef struct tactus_delay {
  tactus_real low, high, rate;
  int first;  ///< frames back that the newest tap can be
} tactus_delay;

/// A loop needs a tap in the past; where the delay is never below a frame, no tap is newer.
static inline tactus_delay tactus_delay_between(tactus_real low, tactus_real high, tactus_real rate) {
  const tactus_delay delay = {low, high, rate, tactus_delay_frames(low, rate) >= 1};
  return delay;
}

static inline tactus_real tactus_delay_inside(const tactus_delay* s, tactus_real seconds) {
  return seconds > s->low ? tactus_min(seconds, s->high) : s->low;
}

/// The least and the most frames from the input to the output.
static inline int tactus_delay_least(const tactus_delay* s, int order) {
  return tactus_delay_newest(tactus_delay_frames(s->low, s->rate), order, s->first);
}
static inline int tactus_delay_most(const tactus_delay* s, int order) {
  const int least = tactus_delay_least(s, order), most = (int)ceil(tactus_delay_frames(s->high, s->rate));
  return most < least ? least : most;
}

/// Where the taps lie for a time in the range: gives the newest, in frames back, and sets the weights.
static inline int tactus_delay_aim(const tactus_delay* s, int order, tactus_real seconds,
                                   tactus_real* weights) {
  const tactus_real frames = tactus_delay_frames(seconds, s->rate);
  const int newest = tactus_delay_newest(frames, order, s->first);
  weights[0] = 1;
  if (order > 0) tactus_lagrange(weights, order + 1, frames - newest);
  return newest;
}

/// The output of the frame that was written `written` frames ago (1: the last one), of a time in the range.
static inline tactus_real tactus_delay_read(const tactus_delay* s, int order, const tactus_line* line,
                                            int written, tactus_real seconds) {
  tactus_real weights[6];
  const int newest = tactus_delay_aim(s, order, seconds, weights);
  const tactus_real* tap = tactus_line_tap(line, newest + written, order);
  return order > 0 ? tactus_tap_sum(tap, weights, order + 1, 0) : *tap;
}

/// `line` holds the longest time and the taps.
static inline tactus_real tactus_delay_step(const tactus_delay* s, int order, tactus_line* line,
                                            tactus_real in, tactus_real time) {
  tactus_line_write(line, in);
  return tactus_delay_read(s, order, line, 1, tactus_delay_inside(s, time));
}
