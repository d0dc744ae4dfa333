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

/// The last samples of a signal in a ring of `capacity`, a power of two, zeros at first.
typedef struct tactus_line {
  tactus_real* samples;
  int capacity, next;
} tactus_line;

static inline void tactus_line_write(tactus_line* s, tactus_real x) {
  s->samples[s->next] = x;
  s->next = (s->next + 1) & (s->capacity - 1);
}

/// start + sum over k of weight[k] times the sample written `back` + k ago (1: the last one), in two chains,
/// even and odd taps, which halves the latency.
static inline tactus_real tactus_line_sum(const tactus_line* s, int back, const tactus_real* weight, int taps,
                                          tactus_real start) {
  tactus_real chains[2] = {start, 0};
  for (int k = 0; k < taps; ++k) {
    const tactus_real tap = s->samples[(s->next - back - k) & (s->capacity - 1)];
    chains[k % 2] = k == 1 ? weight[k] * tap : tactus_fma(weight[k], tap, chains[k % 2]);
  }
  return chains[0] + chains[1];
}
