#pragma once

#include "engine/dsp/envelopes/stroke_net_kernel.h"
#include "engine/dsp/kernel.h"

// Thread: [realtime]; tactus_stroke_start [control].

#define TACTUS_STROKE_PAST 64  ///< frames stored; a power of two, more than lookahead + 55
#define TACTUS_STROKE_FRAME_S 0.0005
#define TACTUS_STROKE_LEAST 1e-9  ///< added to every energy: -90 dBFS

/// Detects strokes in a microphone signal: a small neural network judges, every 0.5 ms, the levels of eight
/// bands in the last 31 ms. n counts frames of 0.5 ms; all that follows is for each band b = 1..8.
///
///     y   = in through a band-pass at 90, 200, 400, 800, 1600, 3200, 6400 Hz (Q 0.8), a high-pass at 9 kHz
///     e   = mean of y^2 in the frame
///     v   = max(e, v exp(-0.5 ms / tau))            tau = 8, 4, 2, 1, 0.5, 0.5, 0.5, 0.5 ms
///     s   = max(v - mask, min(v, s before))         s = v without a reference
///     L   = 10 log10(s + 1e-9)                                                                    [dB]
///     u  += (1 - exp(-0.5 ms / 8 ms)) (e - u)
///     F   = min(10 log10(u + 1e-9), F + 0.005 dB)   the floor; for the first 10 ms the former
///     M(i, j) = max of L(n - i) ... L(n - j);       k = 2, 3, 5, 7 for a lookahead of 0.5, 1, 2, 3 ms
///     r1 = M(k, k + 7), r2 = M(k + 8, k + 23), r3 = M(k + 24, k + 55), recent = M(0, k - 1)
///     early = M(max(1, k / 2), k - 1), m12 = max(r1, r2), mean = mean of L(n - k) ... L(n - k - 23)
///     x   = [L - r1, recent - r1, recent - m12, recent - max(m12, r3), early - r1, r1 - r2, r2 - r3,
///            m12 - mean, r1 - F, recent - F, highest L - r1 of n - k - 2 ... n - k - 39, recent - struck]
///           clipped to -25 ... 40 dB, divided by 10 dB; struck: highest L of the last stroke, from k - 1
///           frames before its decision to 10 after it
///     a   = [exp(-t / 15 ms), exp(-t / 60 ms), exp(-t / 240 ms)]            t: time since that decision
///     h   = q(x W + c)        12 numbers; the same W, c for all bands; q(s) = max(s, 0.05 s)
///     g   = q([h of the bands] V + a A + d)         16 numbers
///     z   = g . w + w0                              log odds of a stroke
///
/// A stroke when z > bar, `hold` or more after the last one, the peak level of the last k + 1 frames above
/// `threshold`; until `second_hold` after the last one z must exceed the bar by `second_margin`, and from
/// 0.3 s after it on by 3: strokes are then e^3 = 20 times rarer, one in seconds instead of ten a second. It
/// is decided at the end of a frame; none in the first 0.1 s.
///
/// The reference is what the instrument itself emits. Its energy r (as e, each band with 1e-4 of the sum of
/// all, for distortion), held by a fall of 5 ms or that of v, predicts what the microphone picks up of it:
/// mask = 10 coupling r, 10 dB above the prediction. The coupling is the lowest ratio of the microphone's
/// highest e of the last 10 ms (the longest acoustic path) to r 10 ms ago: strokes and noise only add to it.
/// It is measured where r is above -80 dBFS and at most 10 dB below its crest of the last 50 ms. Meanwhile it
/// rises by 2 dB a second, to follow a moved microphone, and it falls by at most 200 dB a second after its
/// first 0.2 s, so that a drive which a limit cuts short does not mislead it.
///
/// Bands of or above 0.45 times the sample rate have the energy of the highest band below it.
/// Valid: rate 8 to 192 kHz. An input that is not finite counts as 0.
typedef struct tactus_stroke_bank {
  tactus_real first[TACTUS_STROKE_BANDS], second[TACTUS_STROKE_BANDS], sum[TACTUS_STROKE_BANDS];
} tactus_stroke_bank;

typedef struct tactus_stroke {
  tactus_real level;     ///< peak of the last stroke: so far for its first 5 ms, then held
  tactus_real evidence;  ///< z of the last frame of 0.5 ms

  tactus_stroke_bank heard, thrown;
  tactus_real v[TACTUS_STROKE_BANDS], seen[TACTUS_STROKE_BANDS], u[TACTUS_STROKE_BANDS];
  tactus_real quiet[TACTUS_STROKE_BANDS], floor_db[TACTUS_STROKE_BANDS];
  tactus_real held[TACTUS_STROKE_BANDS], crest[TACTUS_STROKE_BANDS], coupling[TACTUS_STROKE_BANDS];
  tactus_real mean_sum[TACTUS_STROKE_BANDS];
  tactus_real loud[TACTUS_STROKE_PAST][TACTUS_STROKE_BANDS];       ///< L
  tactus_real loudest[TACTUS_STROKE_PAST][TACTUS_STROKE_BANDS];    ///< M(0, 7)
  tactus_real rise[TACTUS_STROKE_PAST][TACTUS_STROKE_BANDS];       ///< L - r1
  tactus_real steepest[TACTUS_STROKE_PAST][TACTUS_STROKE_BANDS];   ///< highest of 8 of them
  tactus_real reference[TACTUS_STROKE_PAST][TACTUS_STROKE_BANDS];  ///< r
  tactus_real energy[TACTUS_STROKE_PAST][TACTUS_STROKE_BANDS];     ///< e, with a reference
  tactus_real energy_5[TACTUS_STROKE_PAST][TACTUS_STROKE_BANDS];   ///< highest of 5 of them
  tactus_real recent[TACTUS_STROKE_BANDS], struck[TACTUS_STROKE_BANDS];
  tactus_real x[TACTUS_STROKE_FEATURES][TACTUS_STROKE_BANDS], after[TACTUS_STROKE_AGES];
  tactus_real peaks[8], peak, high_pass, previous;
  tactus_real left;  ///< samples left of the frame
  int samples;       ///< so far in the frame
  int slot, since, frames, learned[TACTUS_STROKE_BANDS];

  // What does not change.
  const tactus_stroke_net* net;
  tactus_real frame_samples, high_pass_feedback, u_rise, floor_rise, crest_fall, coupling_rise, coupling_fall;
  tactus_real b0[TACTUS_STROKE_BANDS], b1[TACTUS_STROKE_BANDS], b2[TACTUS_STROKE_BANDS];
  tactus_real a1[TACTUS_STROKE_BANDS], a2[TACTUS_STROKE_BANDS], v_fall[TACTUS_STROKE_BANDS],
      held_fall[TACTUS_STROKE_BANDS];
  int bands;  ///< below 0.45 times the sample rate
} tactus_stroke;

/// Of a state of zeros.
static inline void tactus_stroke_start(tactus_stroke* s, tactus_real rate, const tactus_stroke_net* net) {
  static const tactus_real centre_hz[] = {90, 200, 400, 800, 1600, 3200, 6400, 9000};
  static const tactus_real fall_s[] = {0.008, 0.004, 0.002, 0.001, 0.0005, 0.0005, 0.0005, 0.0005};
  const tactus_real least_db = -90, unknown_coupling = 1e12;
  s->net = net;
  s->frame_samples = tactus_max(1.0, rate * TACTUS_STROKE_FRAME_S);
  s->left = s->frame_samples;
  s->high_pass_feedback = 1 / (1 + 2 * 3.14159265358979323846 * 30 / rate);
  s->u_rise = 1 - exp(-TACTUS_STROKE_FRAME_S / 0.008);
  s->floor_rise = pow(10.0, 0.0005);  // 0.005 dB
  s->crest_fall = exp(-TACTUS_STROKE_FRAME_S / 0.050);
  s->coupling_rise = pow(10.0, 0.2 * TACTUS_STROKE_FRAME_S);
  s->coupling_fall = pow(10.0, -20 * TACTUS_STROKE_FRAME_S);
  s->since = 1 << 20;
  for (int b = 0; b < TACTUS_STROKE_BANDS; ++b) {
    // R. Bristow-Johnson, Audio EQ Cookbook: band-pass of 0 dB at its centre, high-pass.
    const int high = b == TACTUS_STROKE_BANDS - 1;
    const tactus_real angle = 2 * 3.14159265358979323846 * tactus_min(centre_hz[b] / rate, 0.45);
    const tactus_real alpha = sin(angle) / (2 * (high ? 0.7 : 0.8));
    const tactus_real scale = 1 / (1 + alpha), pass = high ? (1 + cos(angle)) / 2 : alpha;
    if (centre_hz[b] < 0.45 * rate) s->bands = b + 1;
    s->b0[b] = pass * scale;
    s->b1[b] = high ? -2 * pass * scale : 0;
    s->b2[b] = high ? pass * scale : -pass * scale;
    s->a1[b] = -2 * cos(angle) * scale;
    s->a2[b] = (1 - alpha) * scale;
    s->v_fall[b] = exp(-TACTUS_STROKE_FRAME_S / fall_s[b]);
    s->held_fall[b] = exp(-TACTUS_STROKE_FRAME_S / tactus_max(0.005, fall_s[b]));
    s->coupling[b] = unknown_coupling;
    s->mean_sum[b] = 24 * least_db;
    s->recent[b] = s->struck[b] = least_db;
    for (int n = 0; n < TACTUS_STROKE_PAST; ++n) s->loud[n][b] = s->loudest[n][b] = least_db;
  }
}

/// Samples through the bands: transposed direct form II.
static inline void tactus_stroke_filter(const tactus_stroke* s, tactus_stroke_bank* bank,
                                        const tactus_real* in, int samples) {
  for (int b = 0; b < TACTUS_STROKE_BANDS; ++b)
    for (int n = 0; n < samples; ++n) {
      const tactus_real y = tactus_fma(s->b0[b], in[n], bank->first[b]);
      bank->first[b] = tactus_fma(s->b1[b], in[n], tactus_fma(-s->a1[b], y, bank->second[b]));
      bank->second[b] = tactus_fma(s->b2[b], in[n], -s->a2[b] * y);
      bank->sum[b] = tactus_fma(y, y, bank->sum[b]);
    }
}

/// Energies of a frame, which starts anew.
static inline void tactus_stroke_energies(const tactus_stroke* s, tactus_stroke_bank* bank,
                                          tactus_real e[TACTUS_STROKE_BANDS]) {
  const tactus_real scale = 1.0 / s->samples;
  for (int b = 0; b < TACTUS_STROKE_BANDS; ++b) {
    e[b] = bank->sum[b] * scale;
    bank->sum[b] = 0;
  }
  for (int b = s->bands; b < TACTUS_STROKE_BANDS; ++b) e[b] = e[s->bands - 1];
}

/// What the reference masks in each band.
static inline void tactus_stroke_mask(tactus_stroke* s, const tactus_real e[TACTUS_STROKE_BANDS],
                                      tactus_real mask[TACTUS_STROKE_BANDS]) {
  const tactus_real distortion = 1e-4, margin = 10, active = 1e-8, near_crest = 0.1;
  const int all = TACTUS_STROKE_PAST - 1, n = s->slot, path = 20, first = 400;  // frames: 10 ms, 0.2 s
  tactus_real sum;
  tactus_stroke_energies(s, &s->thrown, s->reference[n]);
  sum = distortion * tactus_sum_of_eight(s->reference[n]);
  for (int b = 0; b < TACTUS_STROKE_BANDS; ++b) {
    const tactus_real r = s->reference[n][b] + sum, before = s->reference[(n - path) & all][b];
    tactus_real heard;
    s->reference[n][b] = r;
    s->energy[n][b] = s->energy_5[n][b] = e[b];
    for (int i = 1; i < 5; ++i)
      s->energy_5[n][b] = tactus_max(s->energy_5[n][b], s->energy[(n - i) & all][b]);
    heard = tactus_max(tactus_max(s->energy_5[n][b], s->energy_5[(n - 5) & all][b]),
                       tactus_max(s->energy_5[(n - 10) & all][b], s->energy_5[(n - 15) & all][b]));
    heard = tactus_max(heard, s->energy[(n - path) & all][b]);
    s->crest[b] = tactus_max(r, s->crest[b] * s->crest_fall);
    if (before > tactus_max(active, near_crest * s->crest[b])) {
      const tactus_real ratio = (heard + TACTUS_STROKE_LEAST) / before;
      const tactus_real fall = s->learned[b] < first ? 0 : s->coupling_fall;
      if (s->learned[b] < first) ++s->learned[b];
      s->coupling[b] =
          tactus_max(s->coupling[b] * fall, tactus_min(s->coupling[b] * s->coupling_rise, ratio));
    }
    s->held[b] = tactus_max(r, s->held[b] * s->held_fall[b]);
    mask[b] = margin * s->coupling[b] * s->held[b];
  }
}

/// The running maxima of a frame.
static inline void tactus_stroke_windows(tactus_stroke* s) {
  const int all = TACTUS_STROKE_PAST - 1;
  for (int b = 0; b < TACTUS_STROKE_BANDS; ++b) {
    tactus_real loudest = s->loud[s->slot][b];
    tactus_real steepest = loudest - s->loudest[(s->slot - s->net->lookahead) & all][b];
    s->rise[s->slot][b] = steepest;
    for (int i = 1; i < 8; ++i) {
      loudest = tactus_max(loudest, s->loud[(s->slot - i) & all][b]);
      steepest = tactus_max(steepest, s->rise[(s->slot - i) & all][b]);
    }
    s->loudest[s->slot][b] = loudest;
    s->steepest[s->slot][b] = steepest;
  }
}

/// Frames left out of `early`.
static inline int tactus_stroke_early(int k) { return k / 2 > 1 ? k / 2 : 1; }

static inline tactus_real tactus_stroke_past(tactus_real past[][TACTUS_STROKE_BANDS], int slot, int b) {
  return past[slot & (TACTUS_STROKE_PAST - 1)][b];
}

/// The numbers that the net sees, of band `b`.
static inline void tactus_stroke_numbers_of(tactus_stroke* s, int b) {
  const int k = s->net->lookahead, n = s->slot, early_from = tactus_stroke_early(k);
  const tactus_real now = s->loud[n][b], r1 = tactus_stroke_past(s->loudest, n - k, b);
  const tactus_real r2 =
      tactus_max(tactus_stroke_past(s->loudest, n - k - 8, b), tactus_stroke_past(s->loudest, n - k - 16, b));
  const tactus_real r3 = tactus_max(tactus_max(tactus_stroke_past(s->loudest, n - k - 24, b),
                                               tactus_stroke_past(s->loudest, n - k - 32, b)),
                                    tactus_max(tactus_stroke_past(s->loudest, n - k - 40, b),
                                               tactus_stroke_past(s->loudest, n - k - 48, b)));
  const tactus_real m12 = tactus_max(r1, r2), quiet_db = s->floor_db[b];
  tactus_real early = tactus_stroke_past(s->loud, n - k + 1, b), recent, steepest;
  for (int i = early_from; i < k - 1; ++i) early = tactus_max(early, tactus_stroke_past(s->loud, n - i, b));
  recent = early;
  for (int i = 0; i < early_from; ++i) recent = tactus_max(recent, tactus_stroke_past(s->loud, n - i, b));
  steepest = tactus_max(tactus_max(tactus_max(tactus_stroke_past(s->steepest, n - k - 2, b),
                                              tactus_stroke_past(s->steepest, n - k - 10, b)),
                                   tactus_max(tactus_stroke_past(s->steepest, n - k - 18, b),
                                              tactus_stroke_past(s->steepest, n - k - 26, b))),
                        tactus_stroke_past(s->steepest, n - k - 32, b));
  s->mean_sum[b] += tactus_stroke_past(s->loud, n - k, b) - tactus_stroke_past(s->loud, n - k - 24, b);
  s->x[0][b] = now - r1;
  s->x[1][b] = recent - r1;
  s->x[2][b] = recent - m12;
  s->x[3][b] = recent - tactus_max(m12, r3);
  s->x[4][b] = early - r1;
  s->x[5][b] = r1 - r2;
  s->x[6][b] = r2 - r3;
  s->x[7][b] = m12 - s->mean_sum[b] * (1.0 / 24);
  s->x[8][b] = r1 - quiet_db;
  s->x[9][b] = recent - quiet_db;
  s->x[10][b] = steepest;
  s->x[11][b] = recent - s->struck[b];
  s->recent[b] = recent;
  for (int i = 0; i < TACTUS_STROKE_FEATURES; ++i)
    s->x[i][b] = tactus_min(tactus_max(s->x[i][b], -25.0), 40.0) * 0.1;
}

static inline void tactus_stroke_numbers(tactus_stroke* s) {
  for (int b = 0; b < TACTUS_STROKE_BANDS; ++b) tactus_stroke_numbers_of(s, b);
}

static inline tactus_real tactus_stroke_bent(tactus_real in) { return tactus_max(in, 0.05 * in); }

/// Log odds of a stroke. Two sums for each joint unit, of the even and of the odd bands: a single chain of
/// additions would take twice the time.
static inline tactus_real tactus_stroke_judge(const tactus_stroke_net* net,
                                              tactus_real x[TACTUS_STROKE_FEATURES][TACTUS_STROKE_BANDS],
                                              const tactus_real after[TACTUS_STROKE_AGES]) {
  const int half = TACTUS_STROKE_JOINT / 2;
  tactus_real g[2][TACTUS_STROKE_JOINT], z[8];
  for (int m = 0; m < TACTUS_STROKE_JOINT; ++m) {
    g[0][m] = net->joint_bias[m];
    g[1][m] = 0;
  }
  for (int i = 0; i < TACTUS_STROKE_AGES; ++i)
    for (int m = 0; m < TACTUS_STROKE_JOINT; ++m) g[1][m] = tactus_fma(after[i], net->age[i][m], g[1][m]);
  for (int j = 0; j < TACTUS_STROKE_HIDDEN; ++j) {
    tactus_real h[TACTUS_STROKE_BANDS];
    for (int b = 0; b < TACTUS_STROKE_BANDS; ++b) h[b] = net->band_bias[j][b];
    for (int i = 0; i < TACTUS_STROKE_FEATURES; ++i) {
      const tactus_real weight = net->band[i][j];
      for (int b = 0; b < TACTUS_STROKE_BANDS; ++b) h[b] = tactus_fma(x[i][b], weight, h[b]);
    }
    for (int b = 0; b < TACTUS_STROKE_BANDS; ++b) {
      const tactus_real* weights = net->joint[b * TACTUS_STROKE_HIDDEN + j];
      const tactus_real in = tactus_stroke_bent(h[b]);
      for (int m = 0; m < TACTUS_STROKE_JOINT; ++m) g[b & 1][m] = tactus_fma(in, weights[m], g[b & 1][m]);
    }
  }
  for (int m = 0; m < half; ++m)
    z[m] = tactus_fma(tactus_stroke_bent(g[0][m + half] + g[1][m + half]), net->last[m + half],
                      tactus_stroke_bent(g[0][m] + g[1][m]) * net->last[m]);
  return tactus_sum_of_eight(z) + net->last_bias;
}

/// Levels of a frame, into `loud` and the floor. `referenced`: there is a reference.
static inline void tactus_stroke_levels(tactus_stroke* s, int referenced) {
  const tactus_real db = 4.34294481903251828;  // 10 / log(10)
  const int settle = 20;                       // frames: 10 ms
  tactus_real e[TACTUS_STROKE_BANDS], mask[TACTUS_STROKE_BANDS];
  s->slot = (s->slot + 1) & (TACTUS_STROKE_PAST - 1);
  tactus_stroke_energies(s, &s->heard, e);
  if (referenced) tactus_stroke_mask(s, e, mask);
  for (int b = 0; b < TACTUS_STROKE_BANDS; ++b) {
    s->v[b] = tactus_max(e[b], s->v[b] * s->v_fall[b]);
    s->u[b] += s->u_rise * (e[b] - s->u[b]);
    s->quiet[b] *= s->floor_rise;
    s->floor_db[b] += 0.005;
  }
  for (int b = 0; b < TACTUS_STROKE_BANDS; ++b) {
    const tactus_real u = s->u[b] + TACTUS_STROKE_LEAST;
    if (s->frames < settle || u < s->quiet[b]) {
      s->quiet[b] = u;
      s->floor_db[b] = db * log(u);
    }
  }
  // What is masked holds the level before: it must not look like a rise, and its end neither.
  for (int b = 0; b < TACTUS_STROKE_BANDS; ++b)
    s->seen[b] = referenced ? tactus_max(s->v[b] - mask[b], tactus_min(s->v[b], s->seen[b])) : s->v[b];
  for (int b = 0; b < TACTUS_STROKE_BANDS; ++b)
    s->loud[s->slot][b] = db * log(s->seen[b] + TACTUS_STROKE_LEAST);
}

/// The frame that ends has a stroke of level `peak`.
static inline void tactus_stroke_strike(tactus_stroke* s, tactus_real peak) {
  s->since = 0;
  s->level = peak;
  for (int i = 0; i < TACTUS_STROKE_AGES; ++i) s->after[i] = 1;
  for (int b = 0; b < TACTUS_STROKE_BANDS; ++b) s->struck[b] = s->recent[b];
}

/// What the net sees of the last stroke ages by a frame.
static inline void tactus_stroke_age(tactus_stroke* s) {
  static const tactus_real fall[] = {0.96721610048200462, 0.991701292638876, 0.9979188352992993};
  const int level_frames = 10;  // 5 ms
  for (int i = 0; i < TACTUS_STROKE_AGES; ++i) s->after[i] *= fall[i];
  if (s->since < level_frames)
    for (int b = 0; b < TACTUS_STROKE_BANDS; ++b)
      s->struck[b] = tactus_max(s->struck[b], s->loud[s->slot][b]);
}

/// The end of a frame: whether it has a stroke.
static inline int tactus_stroke_decide(tactus_stroke* s, tactus_real evidence, tactus_real threshold,
                                       tactus_real hold) {
  const int first_frame = 200, level_frames = 10;  // 0.1 s, 5 ms
  const tactus_real rest_s = 0.3, rest_margin = 3;
  const tactus_real waited_s = (s->since + 1) * TACTUS_STROKE_FRAME_S + 1e-9;
  tactus_real peak = 0, bar = s->net->bar;
  int stroke;
  s->evidence = tactus_clamp(evidence, -50.0, 50.0);
  s->peaks[s->slot & 7] = s->peak;
  s->peak = 0;
  s->samples = 0;
  s->left += s->frame_samples;
  if (s->frames < first_frame) ++s->frames;
  if (s->since < 1 << 20) ++s->since;
  for (int i = 0; i <= s->net->lookahead; ++i) peak = tactus_max(peak, s->peaks[(s->slot - i) & 7]);
  if (waited_s < s->net->second_hold_s) bar += s->net->second_margin;
  if (waited_s > rest_s) bar += rest_margin;
  stroke = s->frames >= first_frame && s->evidence > bar && waited_s >= hold && peak > threshold;
  if (stroke) {
    tactus_stroke_strike(s, peak);
  } else if (s->since <= level_frames) {
    s->level = tactus_max(s->level, s->peaks[s->slot & 7]);
  }
  return stroke;
}

static inline tactus_real tactus_stroke_finite(tactus_real in) {
  return tactus_is_finite(in) ? tactus_clamp(in, -1e6, 1e6) : 0;
}

/// Samples up to the end of the frame, at most `most`.
static inline int tactus_stroke_samples_left(const tactus_stroke* s, int most) {
  const int left = (int)ceil(s->left - 0.5);
  return left < 1 ? 1 : left < most ? left : most;
}

/// The peak above 30 Hz.
static inline void tactus_stroke_measure(tactus_stroke* s, const tactus_real* in, int samples) {
  tactus_real high_pass = s->high_pass, peak = s->peak, previous = s->previous;
  for (int n = 0; n < samples; ++n) {
    high_pass = s->high_pass_feedback * (high_pass + (in[n] - previous));
    previous = in[n];
    peak = tactus_max(peak, tactus_max(high_pass, -high_pass));
  }
  s->high_pass = high_pass;
  s->peak = peak;
  s->previous = previous;
}

static inline int tactus_stroke_ends(tactus_stroke* s, int samples) {
  s->samples += samples;
  s->left -= samples;
  return s->left < 0.5;
}

/// At most `tactus_stroke_samples_left` samples, of which the last has a stroke if this returns 1. `in` and
/// `reference` are finite; a null `reference`: none.
static inline int tactus_stroke_follow(tactus_stroke* s, const tactus_real* in, const tactus_real* reference,
                                       int samples, tactus_real threshold, tactus_real hold) {
  tactus_stroke_measure(s, in, samples);
  tactus_stroke_filter(s, &s->heard, in, samples);
  if (reference) tactus_stroke_filter(s, &s->thrown, reference, samples);
  if (!tactus_stroke_ends(s, samples)) return 0;
  tactus_stroke_levels(s, reference != 0);
  tactus_stroke_age(s);
  tactus_stroke_windows(s);
  tactus_stroke_numbers(s);
  return tactus_stroke_decide(s, tactus_stroke_judge(s->net, s->x, s->after), threshold, hold);
}

/// 1 in the frame of a stroke. `in`, `reference` and `threshold` in full scales, `hold` in seconds.
/// `referenced`: whether there is a reference; if not, `reference` is ignored.
static inline int tactus_stroke_step(tactus_stroke* s, tactus_real in, tactus_real reference,
                                     tactus_real threshold, tactus_real hold, int referenced) {
  const tactus_real x = tactus_stroke_finite(in), thrown = tactus_stroke_finite(reference);
  return tactus_stroke_follow(s, &x, referenced ? &thrown : 0, 1, threshold, hold);
}
