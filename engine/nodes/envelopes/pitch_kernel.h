#pragma once

// Thread: [realtime].

#include "engine/dsp/kernel.h"

/// How often a signal repeats itself, found anew every `hop` frames:
///
///   n(t) = 2 sum x[j] x[j - t] / sum (x[j]^2 + x[j - t]^2)   over the last t frames and a little more, x
///   without DC
///
/// The period is the first maximum of n above 0.9 of its highest: first at a lower rate, then at the full one
/// around it, with a parabola through the three values at the top. It needs the last two periods. Source:
/// McLeod & Wyvill, ICMC 2005.
typedef struct tactus_pitch {
  // Set by `tactus_pitch_start`.
  tactus_real rate, dc_rise;
  int hop, decimation, shortest, longest;  ///< periods at the lower rate
  int full_frames, small_frames;           ///< that are kept at each rate; memory for twice as many is needed
  // State.
  tactus_real dc, sum;
  int frame, full_at, small_at;
  tactus_real frequency, clarity;
} tactus_pitch;

/// The window beyond one period, in frames of the lower rate; windows are whole eights.
#define TACTUS_PITCH_EXTRA 32

static inline int tactus_pitch_window(int lag) { return (lag + TACTUS_PITCH_EXTRA + 7) / 8 * 8; }

/// 0 < lowest < highest, in Hz.
static inline void tactus_pitch_start(tactus_pitch* s, tactus_real rate, tactus_real lowest,
                                      tactus_real highest) {
  s->rate = rate;
  s->dc_rise = 1.0 - exp(-6.283185307179586 * 0.25 * lowest / rate);
  s->hop = (int)tactus_max(1.0, 0.005 * rate);
  s->decimation = (int)tactus_clamp(rate / (10.0 * highest), 1.0, 64.0);
  s->shortest = (int)tactus_max(2.0, floor(rate / (highest * s->decimation)));
  s->longest = (int)ceil(rate / (lowest * s->decimation)) + 1;
  s->small_frames = s->longest + 1 + tactus_pitch_window(s->longest + 1);
  s->full_frames = s->decimation * (s->longest + 2) + tactus_pitch_window(s->decimation * (s->longest + 2));
}

/// Appends to a line that is kept twice, so that its last `frames` samples always lie in a row; returns their
/// end.
static inline const tactus_real* tactus_pitch_keep(tactus_real* line, int frames, int* at, tactus_real x) {
  line[*at] = line[*at + frames] = x;
  *at = *at + 1 < frames ? *at + 1 : 0;
  return line + *at + frames;
}

/// n(lag), from the samples before `end`. Eight sums, so that it can be vectorised with the same bits.
static inline tactus_real tactus_pitch_likeness(const tactus_real* end, int lag) {
  const int window = tactus_pitch_window(lag);
  const tactus_real *x = end - window, *earlier = x - lag;
  tactus_real both[8] = {0}, each[8] = {0};
  for (int j = 0; j < window; j += 8)
    for (int k = 0; k < 8; ++k) {
      both[k] += x[j + k] * earlier[j + k];
      each[k] += x[j + k] * x[j + k] + earlier[j + k] * earlier[j + k];
    }
  const tactus_real power = tactus_sum_of_eight(each);
  return power > 0 ? 2.0 * tactus_sum_of_eight(both) / power : 0.0;
}

/// The first maximum above 0.9 of the highest, at the lower rate; 0: none.
static inline int tactus_pitch_period(const tactus_pitch* s, const tactus_real* end) {
  enum { kMost = 64 };
  int lags[kMost], count = 0,
                   below = 0;  // `below`: n has been below 0.5 since a lag of 0, whose top is no period
  tactus_real tops[kMost], highest = 0;
  tactus_real before = tactus_pitch_likeness(end, 1), here = tactus_pitch_likeness(end, 2);
  for (int lag = 2; lag <= s->longest && count < kMost; ++lag) {
    const tactus_real after = tactus_pitch_likeness(end, lag + 1);
    below = below || before < 0.5;
    if (below && lag >= s->shortest && here >= before && here > after && here > 0) {
      lags[count] = lag;
      tops[count++] = here;
      highest = tactus_max(highest, here);
    }
    before = here;
    here = after;
  }
  for (int k = 0; k < count; ++k)
    if (tops[k] >= 0.9 * highest) return lags[k];
  return 0;
}

/// Frequency and clarity from the lines as they are.
static inline void tactus_pitch_find(tactus_pitch* s, const tactus_real* full_end,
                                     const tactus_real* small_end) {
  const int coarse = tactus_pitch_period(s, small_end), width = s->decimation;
  int best = 0;
  tactus_real highest = -1;
  s->clarity = 0;
  if (coarse == 0) return;
  for (int lag = coarse * width - width; lag <= coarse * width + width; ++lag) {
    const tactus_real here = lag > 1 ? tactus_pitch_likeness(full_end, lag) : -1.0;
    if (here <= highest) continue;
    highest = here;
    best = lag;
  }
  if (best < 2) return;
  const tactus_real before = tactus_pitch_likeness(full_end, best - 1),
                    after = tactus_pitch_likeness(full_end, best + 1);
  const tactus_real bend = before - 2.0 * highest + after;
  const tactus_real aside = bend < 0 ? tactus_clamp(0.5 * (before - after) / bend, -0.5, 0.5) : 0.0;
  s->clarity = tactus_clamp(highest, 0.0, 1.0);
  s->frequency = s->rate / ((tactus_real)best + aside);
}

/// `full` and `small` hold 2 full_frames and 2 small_frames numbers.
static inline void tactus_pitch_step(tactus_pitch* s, tactus_real* full, tactus_real* small, tactus_real in) {
  s->dc += s->dc_rise * (in - s->dc);
  const tactus_real x = in - s->dc;
  const tactus_real* const full_end = tactus_pitch_keep(full, s->full_frames, &s->full_at, x);
  const tactus_real* small_end = small + s->small_at + s->small_frames;
  s->sum += x;
  ++s->frame;
  if (s->frame % s->decimation == 0) {
    small_end = tactus_pitch_keep(small, s->small_frames, &s->small_at, s->sum / s->decimation);
    s->sum = 0;
  }
  if (s->frame % (s->hop * s->decimation) == 0) s->frame = 0;
  if (s->frame % s->hop == 0) tactus_pitch_find(s, full_end, small_end);
}
