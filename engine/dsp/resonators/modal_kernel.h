#pragma once

#include "engine/dsp/kernel.h"

// Thread: [realtime].

/// A damped sine: h(t) = gain e^(-t / tau) sin(2 pi frequency t), 60 dB down after `decay` seconds, tau =
/// decay / ln 1000. The resonator with exactly these samples (impulse invariance):
///
///   y[n] = 2 r cos(w) y[n-1] - r^2 y[n-2] + x[n-1],  out = gain r sin(w) y
///   w = 2 pi frequency / fs,  r = e^(-1 / (tau fs))
///
/// An impulse of 1 at frame 0 gives gain r^n sin(w n). Stable: r < 1 for every decay. It runs on differences,
/// which keep the frequency of a low mode to a rounding, where 2 r cos(w) would lose a factor 1 / w^2:
///
///   d[n] = y[n] - y[n-1] = turn d[n-1] - pull y[n-2] + x[n-1]
///   turn = 2 r cos(w) - 1,  pull = 1 - 2 r cos(w) + r^2 = (1 - r)^2 + 4 r sin^2(w / 2)
///
/// A mode that is retuned while it rings continues with the same phase and amplitude: with P[n] = r e^(jw)
/// (P[n-1] + x[n-1]), out = gain Im P, it is P that stays. So no movement of the frequency adds energy.
///
/// Source: Rabiner & Gold, Theory and Application of Digital Signal Processing, 1975, section 4.5;
/// sensitivity: Agarwal & Burrus, "New recursive digital filter structures having very low sensitivity and
/// roundoff noise", IEEE Trans. Circuits and Systems 22(12), 1975.
typedef struct tactus_mode {
  tactus_real turn, pull, gain;
  tactus_real cosine, sine;  ///< r cos(w), r sin(w)
} tactus_mode;

/// Silent from half the sample rate up: forgets at once. The decay is clamped to [0.1 ms, 10000 s].
static inline tactus_mode tactus_mode_design(tactus_real frequency, tactus_real decay, tactus_real gain,
                                             tactus_real rate) {
  const tactus_real turns = frequency / rate, w = 6.283185307179586 * turns;
  const tactus_real r = exp(-3 * 2.302585092994046 / (tactus_clamp(decay, 1e-4, 1e4) * rate));
  tactus_mode mode = {-1, 1, 0, 0, 0};
  if (!(turns > 0 && turns < 0.5)) return mode;
  mode.cosine = r * cos(w);
  mode.sine = r * sin(w);
  mode.turn = 2 * mode.cosine - 1;
  mode.pull = (1 - r) * (1 - r) + 4 * r * sin(w / 2) * sin(w / 2);
  mode.gain = gain * mode.sine;
  return mode;
}

/// Eight modes, each in a lane of a vector register. Zeros are no modes: each is set first.
typedef struct tactus_modes {
  tactus_real turn[8], minus_pull[8], gain[8], cosine[8], sine[8];
  tactus_real last[8], before[8], change[8];  ///< y[n-1], y[n-2] and their difference
} tactus_modes;

/// From the next frame on; ringing continues. From y to P by the old design, and back by the new one:
/// Im P = r sin(w) y[n], Re P = r cos(w) y[n] - r^2 y[n-1].
static inline void tactus_modes_set(tactus_modes* s, int lane, tactus_mode mode) {
  const tactus_real square = s->turn[lane] - s->minus_pull[lane];
  const tactus_real imaginary = s->sine[lane] * s->last[lane];
  const tactus_real real = s->cosine[lane] * s->last[lane] - square * s->before[lane];
  const int sounds = mode.sine > 0;
  s->gain[lane] = mode.gain;
  if (s->turn[lane] == mode.turn && s->minus_pull[lane] == -mode.pull) return;
  s->last[lane] = sounds ? imaginary / mode.sine : 0;
  s->before[lane] = sounds ? (mode.cosine * s->last[lane] - real) / (mode.turn + mode.pull) : 0;
  s->change[lane] = s->last[lane] - s->before[lane];
  s->turn[lane] = mode.turn;
  s->minus_pull[lane] = -mode.pull;
  s->cosine[lane] = mode.cosine;
  s->sine[lane] = mode.sine;
}

/// All modes of `count` groups of eight, summed; `in` is the input of the frame before. The order of
/// additions is fixed: each lane adds its modes in their order, the lanes are added last.
static inline tactus_real tactus_modal_step(tactus_modes* groups, int count, tactus_real in) {
  tactus_real sums[8] = {0};
  for (tactus_modes* s = groups; s < groups + count; ++s)
    for (int k = 0; k < 8; ++k) {
      s->change[k] = tactus_fma(s->turn[k], s->change[k], tactus_fma(s->minus_pull[k], s->before[k], in));
      s->before[k] = s->last[k];
      s->last[k] += s->change[k];
      sums[k] = tactus_fma(s->gain[k], s->last[k], sums[k]);
    }
  return tactus_sum_of_eight(sums);
}
