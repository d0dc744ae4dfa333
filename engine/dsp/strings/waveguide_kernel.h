#pragma once

#include "engine/dsp/strings/string_kernel.h"

// Thread: [any] designs, [realtime] steps.

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
  tactus_real out;
  tactus_line_write(line, in);
  out = tactus_line_sum(line, design->newest + 1, design->taps, TACTUS_STRING_TAPS, 0);
  return one_pole ? tactus_filter_step(pole, out, position) : out;
}
