#pragma once

#include "engine/dsp/kernel.h"

// Thread: [realtime]; tactus_onset_start [control].

#define TACTUS_ONSET_BANDS 4
#define TACTUS_ONSET_PAST 32   ///< groups stored: more than the window of `ring`
#define TACTUS_ONSET_AGO 1000  ///< groups: long ago

/// Detects hits in a microphone signal: soft ones after loud ones, and ringing ones only once.
///
///     y_b   = in, twice through a one-pole high-pass at f_b       f = 30 Hz, 400 Hz, 2 kHz, 7 kHz
///     e_b   = max(|y_b|, e_b exp(-T / tau_b))                     fast envelope, tau = 20, 1, 1, 1 ms
///     bar_b = max(q_b threshold, margin mask_b, margin ring_b, noise_margin floor_b)
///     hit when e_0 > threshold and e_b > bar_b in any band, `hold` or more after the last hit
///
/// Four bands, because a drum rings where it is tuned and a new stroke also excites other frequencies; a
/// weighting towards high frequencies is the usual way to detect it (Bello et al., IEEE Trans. Speech Audio
/// Process. 13, 2005, section III). In each band:
///
/// - mask: the highest envelope of the last hit until its hold was over. Stays for 10 ms more, then falls by
///   20 dB every `mask_time` (by 3 dB in band 0, where drums ring near their peak for long).
/// - ring: the highest envelope of the last 28 ms but the newest 5 (7 in band 0), the oldest counting 3 dB
///   less: what rings and beats, which a stroke outdoes at once. It counts 3 dB more for strokes that stay
///   4 dB or more below the last.
/// - quiet: the mean |y_b|. It falls at once and rises by 20 dB a second, but not in the 0.1 s after a hit,
///   so that a long roll does not become noise.
///
/// The upper bands detect nothing for 20, 45 and 60 ms after a hit, because the wires of a snare strike
/// again. The bars change once a millisecond, at the end of a group of frames. All these times but the 5 and
/// 7 ms are for `ringing` = 28 ms, and go with it. The numbers were found on the training half of the
/// recordings of docs/onset_study.md.
///
/// `high_pass` above 30 Hz is for a microphone that also picks up an actuator: hits are then detected only
/// above it, while their strength is still that of the whole signal.
///
/// Valid: rate >= 16 kHz, high_pass below a quarter of it. It starts from silence; the first frame counts as
/// silence, whatever its DC component.
typedef struct tactus_onset {
  tactus_real level;  ///< highest envelope of the last hit: so far for its first 5 ms, then held
  tactus_real previous;
  tactus_real fast[TACTUS_ONSET_BANDS];  ///< envelopes; the first is that above 30 Hz, in full scales
  tactus_real first[TACTUS_ONSET_BANDS], second[TACTUS_ONSET_BANDS];
  tactus_real mean[TACTUS_ONSET_BANDS], group[TACTUS_ONSET_BANDS], last[TACTUS_ONSET_BANDS];
  tactus_real mask[TACTUS_ONSET_BANDS], quiet[TACTUS_ONSET_BANDS], bar[TACTUS_ONSET_BANDS];
  tactus_real past[TACTUS_ONSET_PAST][TACTUS_ONSET_BANDS];
  int started, frame, slot;  ///< `frame` of the group, `slot` in `past`
  int hold;                  ///< frames left in which nothing counts as a hit
  int groups_since;          ///< since the last hit
  int groups_free;           ///< since its hold was over
  int groups;                ///< since the first frame

  // What does not change.
  tactus_real rate, mean_rise, floor_rise;
  tactus_real feedback[TACTUS_ONSET_BANDS], fast_fall[TACTUS_ONSET_BANDS], mask_fall[TACTUS_ONSET_BANDS];
  tactus_real blocked[TACTUS_ONSET_BANDS];
  int group_frames, window, mask_stays;  ///< the latter two in groups
} tactus_onset;

/// Of a state of zeros. Times in seconds. `ringing`: how long what is struck rings and rattles, 8 to 31 ms:
/// the window of `ring`, and in proportion the time for which the mask stays and the upper bands detect
/// nothing. Two strokes closer than this count as two only if the second is the louder.
static inline void tactus_onset_start(tactus_onset* s, tactus_real rate, tactus_real high_pass,
                                      tactus_real mask_time, tactus_real ringing) {
  static const tactus_real cutoff_hz[] = {30, 400, 2000, 7000}, fall_s[] = {0.020, 0.001, 0.001, 0.001};
  static const tactus_real blocked[] = {0, 20, 45, 60};     // groups
  static const tactus_real mask_speed[] = {0.15, 1, 1, 1};  // a fundamental rings near its peak for long
  const tactus_real window = tactus_clamp(ringing / 0.001, 8.0, TACTUS_ONSET_PAST - 1.0);
  tactus_real group_s;
  s->groups_since = s->groups_free = TACTUS_ONSET_AGO;
  s->rate = rate;
  s->window = (int)lround(window);
  s->mask_stays = (int)lround(10 * window / 28);
  s->group_frames = (int)lround(0.001 * rate);
  if (s->group_frames < 1) s->group_frames = 1;
  group_s = s->group_frames / rate;
  for (int b = 0; b < TACTUS_ONSET_BANDS; ++b) {
    const tactus_real cutoff = b > 0 ? tactus_max(cutoff_hz[b], high_pass) : cutoff_hz[0];
    s->blocked[b] = b > 0 || high_pass <= cutoff_hz[0] ? blocked[b] * window / 28 : HUGE_VAL;
    s->feedback[b] = 1 / (1 + 2 * 3.14159265358979323846 * cutoff / rate);
    s->fast_fall[b] = exp(-1 / (rate * fall_s[b]));
    s->mask_fall[b] = pow(10.0, -20 * group_s * mask_speed[b] / mask_time / 20.0);
  }
  s->mean_rise = 1 - exp(-1 / (rate * 0.004));
  s->floor_rise = pow(10.0, 20 * group_s / 20.0);
}

/// What rings in each band.
static inline void tactus_onset_ringing(const tactus_onset* s, tactus_real ring[TACTUS_ONSET_BANDS]) {
  const tactus_real fall = 0.986279;  // -0.12 dB a group
  const int newest = 5;               // groups that are left out
  const int newest_low = 2;           // so many more in band 0, where a cycle is long
  tactus_real low = 0;
  for (int b = 0; b < TACTUS_ONSET_BANDS; ++b) ring[b] = 0;
  for (int k = s->window - 1; k >= newest; --k) {
    const tactus_real* past = s->past[(s->slot - k) & (TACTUS_ONSET_PAST - 1)];
    for (int b = 0; b < TACTUS_ONSET_BANDS; ++b) ring[b] = tactus_max(past[b], ring[b] * fall);
    if (k == newest + newest_low) low = ring[0];
  }
  for (int k = 0; k < newest_low; ++k) low *= fall;
  ring[0] = low;
}

/// The end of a hold: what began in it belongs to the hit, also where the bars are older than that.
static inline void tactus_onset_end_hold(tactus_onset* s, tactus_real margin) {
  for (int b = 0; b < TACTUS_ONSET_BANDS; ++b) {
    s->mask[b] = s->last[b] = tactus_max(s->group[b], s->last[b]);
    s->bar[b] = tactus_max(s->mask[b] * margin, s->bar[b]);
  }
  s->groups_free = 0;
}

static inline int tactus_onset_count(int groups) { return groups < TACTUS_ONSET_AGO ? groups + 1 : groups; }

/// Band `b` at the end of a group.
static inline void tactus_onset_close_band(tactus_onset* s, int b, tactus_real ring, tactus_real threshold,
                                           tactus_real margin, tactus_real noise_margin) {
  static const tactus_real thresholds[] = {0.89, 0.22, 0.089, 0.071};  // -1, -13, -21, -23 dB
  static const tactus_real ring_margin[] = {1.06, 1.06, 1, 1};         // the fundamentals of a drum beat most
  const tactus_real soft_margin = 1.41, soft = 0.63;                   // 3 dB, -4 dB
  const tactus_real least_floor = 1e-5;  // after digital silence the floor must find its way up
  tactus_real stroke;
  if (s->hold > 0) s->mask[b] = s->last[b] = tactus_max(s->group[b], s->last[b]);
  if (s->groups_free >= s->mask_stays) s->mask[b] *= s->mask_fall[b];
  if (s->groups_since > 100) s->quiet[b] *= s->floor_rise;
  s->quiet[b] = s->groups < 10 ? s->mean[b] : tactus_min(s->quiet[b], s->mean[b]);
  s->quiet[b] = tactus_max(least_floor, s->quiet[b]);
  ring = ring * ring_margin[b] * margin;
  stroke = tactus_max(tactus_min(s->last[b] * soft, ring * soft_margin), ring);
  s->bar[b] = tactus_max(tactus_max(thresholds[b] * threshold, s->quiet[b] * noise_margin),
                         tactus_max(s->mask[b] * margin, stroke));
  if (s->groups_since < s->blocked[b]) s->bar[b] = HUGE_VAL;
  s->group[b] = s->fast[b];
}

static inline void tactus_onset_close_group(tactus_onset* s, tactus_real threshold, tactus_real margin,
                                            tactus_real noise_margin) {
  tactus_real ring[TACTUS_ONSET_BANDS];
  s->frame = 0;
  s->slot = (s->slot + 1) & (TACTUS_ONSET_PAST - 1);
  for (int b = 0; b < TACTUS_ONSET_BANDS; ++b) s->past[s->slot][b] = s->group[b];
  tactus_onset_ringing(s, ring);
  for (int b = 0; b < TACTUS_ONSET_BANDS; ++b)
    tactus_onset_close_band(s, b, ring[b], threshold, margin, noise_margin);
  s->groups_since = tactus_onset_count(s->groups_since);
  s->groups_free = s->hold > 0 ? 0 : tactus_onset_count(s->groups_free);
  s->groups = tactus_onset_count(s->groups);
}

/// The envelopes of a frame; whether any reaches above its bar.
static inline int tactus_onset_follow(tactus_onset* s, tactus_real in) {
  const tactus_real step = s->started ? in - s->previous : 0.0;
  int above = 0;
  s->started = 1;
  s->previous = in;
  for (int b = 0; b < TACTUS_ONSET_BANDS; ++b) {
    const tactus_real first = s->feedback[b] * (s->first[b] + step);
    const tactus_real second = s->feedback[b] * (s->second[b] + (first - s->first[b]));
    const tactus_real size = tactus_max(-second, second);
    s->first[b] = first;
    s->second[b] = second;
    s->fast[b] = tactus_max(s->fast[b] * s->fast_fall[b], size);
    s->mean[b] += s->mean_rise * (size - s->mean[b]);
    s->group[b] = tactus_max(s->fast[b], s->group[b]);
    above |= s->fast[b] > s->bar[b];
  }
  return above;
}

/// Whether the level of the last hit still rises.
static inline int tactus_onset_rises(const tactus_onset* s) { return s->groups_since < 5; }

/// 1 in the frame of a hit, `above` being what `tactus_onset_follow` returned for it.
static inline int tactus_onset_decide(tactus_onset* s, int above, tactus_real threshold, tactus_real hold,
                                      tactus_real margin, tactus_real noise_margin) {
  int hit = 0;
  if (s->hold > 0) {
    if (--s->hold == 0) tactus_onset_end_hold(s, margin);
  } else if (above && s->fast[0] > threshold) {
    hit = 1;
    s->hold = (int)(tactus_max(0.001, tactus_min(hold, 10.0)) * s->rate - 0.5);
    s->groups_since = 0;
    s->level = 0;
    for (int b = 0; b < TACTUS_ONSET_BANDS; ++b) s->mask[b] = s->last[b] = s->fast[b];
  }
  if (tactus_onset_rises(s)) s->level = tactus_max(s->level, s->fast[0]);
  if (++s->frame >= s->group_frames) tactus_onset_close_group(s, threshold, margin, noise_margin);
  return hit;
}

/// `in` and `threshold` in full scales; `hold` in seconds, from 1 ms to 10 s; `margin` of a hit over mask and
/// ringing, `noise_margin` over the mean noise (7: 17 dB, 15 dB over the RMS of Gaussian noise).
static inline int tactus_onset_step(tactus_onset* s, tactus_real in, tactus_real threshold, tactus_real hold,
                                    tactus_real margin, tactus_real noise_margin) {
  return tactus_onset_decide(s, tactus_onset_follow(s, in), threshold, hold, margin, noise_margin);
}
