#pragma once

// Thread: [realtime].

#include "engine/dsp/delays/taps_kernel.h"
#include "engine/dsp/envelopes/envelope_kernel.h"

#define TACTUS_ALIGN_TAPS 4
#define TACTUS_ALIGN_LONGEST 0.1       ///< period [s]: 10 Hz, the lowest string
#define TACTUS_ALIGN_MOST_REST 1000.0  ///< delay [s] and phase [rad] of the rest of the loop

/// Where taps of the line lie: the newest, in frames back, and what each weighs.
typedef struct tactus_align_taps {
  int newest;
  tactus_real weights[TACTUS_ALIGN_TAPS];
} tactus_align_taps;

/// Delay that makes a loop a whole number of periods long at its pitch:
///
///   pad = k P − rest,   rest = delay − phase P / 2π
///
/// P [s] is one period, `delay` [s] what the loop takes without the pad, `phase` [rad] what turns in it
/// besides (below 0 it lags). k is chosen when a note starts, the least with a pad of at least a frame; after
/// that the pad follows P with the same k, up to a frame + 1.5 P: so wide that a vibrato at one end of it
/// moves to the middle and stays there. While the pad moves from one k to another there are two taps, where
/// it is and where it was. Their gains add up to 1: at the pitch both are in phase. Source: Berdahl, Steiner
/// & Oldham, NIME 2008, section 7.2, for the loop; k P from the condition of oscillation (Barkhausen).
typedef struct tactus_align {
  tactus_rise rise;
  int started, note, on;
  tactus_real period, pad, turns;  ///< [s], [s], k
  int fading;                      ///< frames left
  tactus_align_taps now, before;

  // What does not change.
  tactus_delay delay;                                  ///< the pad
  tactus_real frame, shortest_period, longest_period;  ///< [s]
  int fade_frames;
} tactus_align;

static inline tactus_real tactus_align_longest_pad(const tactus_align* s, tactus_real period) {
  return s->frame + 1.5 * period;
}
static inline tactus_real tactus_align_period(const tactus_align* s, tactus_real period) {
  return tactus_clamp(period, s->shortest_period, s->longest_period);
}
static inline tactus_real tactus_align_rest(tactus_real period, tactus_real delay, tactus_real phase) {
  // Signals may be outside the declared range, which constants cannot be.
  const tactus_real taken = tactus_clamp(delay, -TACTUS_ALIGN_MOST_REST, TACTUS_ALIGN_MOST_REST);
  const tactus_real turned = tactus_clamp(phase, -TACTUS_ALIGN_MOST_REST, TACTUS_ALIGN_MOST_REST);
  return taken - turned * period / 6.283185307179586;
}
/// k of a new note.
static inline tactus_real tactus_align_turns(const tactus_align* s, tactus_real period, tactus_real rest) {
  return ceil((rest + s->frame) / period);
}

static inline void tactus_align_aim(tactus_align* s, tactus_real pad) {
  const tactus_real inside = tactus_delay_inside(&s->delay, pad);
  if (inside != s->pad) {
    s->pad = inside;
    s->now.newest = tactus_delay_aim(&s->delay, TACTUS_ALIGN_TAPS - 1, inside, s->now.weights);
  }
}

/// Of a state of zeros.
static inline void tactus_align_start(tactus_align* s, tactus_real rate, tactus_real longest_period) {
  s->frame = 1 / rate;
  s->shortest_period = 2 * s->frame;
  s->longest_period = tactus_clamp(longest_period, s->shortest_period, TACTUS_ALIGN_LONGEST);
  s->delay = tactus_delay_between(0, tactus_align_longest_pad(s, s->longest_period), rate);
  s->fade_frames = (int)lround(0.010 / s->frame);
  s->now.weights[0] = s->before.weights[0] = 1;
}

static inline void tactus_align_move(tactus_align* s, int on, tactus_real period, tactus_real rest) {
  const tactus_real pad_before = s->pad;
  s->on = on;
  s->turns = tactus_align_turns(s, period, rest);
  s->note = 0;
  s->before = s->now;
  tactus_align_aim(s, on ? s->turns * period - rest : 0.0);
  if (s->started && s->pad != pad_before) s->fading = s->fade_frames;
  s->started = 1;
}

/// Sets the taps of a frame. A note starts at a trigger, or where the period jumps by half a semitone.
static inline void tactus_align_follow(tactus_align* s, tactus_real wanted_period, tactus_real delay,
                                       tactus_real phase, tactus_real trigger, tactus_real wanted_on) {
  const tactus_real half_semitone = 0.0293;  // 2^(1/24) - 1
  const tactus_real period = tactus_align_period(s, wanted_period);
  const tactus_real rest = tactus_align_rest(period, delay, phase), pad = s->turns * period - rest;
  const int on = wanted_on >= 0.5;
  const int serves = pad >= s->frame && pad <= tactus_align_longest_pad(s, period);
  const int jumped =
      s->started && tactus_max(period, s->period) > (1 + half_semitone) * tactus_min(period, s->period);
  s->note |= tactus_rise_step(&s->rise, trigger) | jumped;
  s->period = period;
  // While one move is under way, a new note has to wait.
  if ((!s->started || s->note || on != s->on || !serves) && s->fading == 0)
    tactus_align_move(s, on, period, rest);
  if (!s->note) tactus_align_aim(s, s->on ? s->turns * period - rest : 0.0);
}

static inline tactus_real tactus_align_sum(const tactus_align_taps* taps, const tactus_line* line,
                                           int written) {
  const tactus_real* newest = tactus_line_tap(line, taps->newest + written, TACTUS_ALIGN_TAPS - 1);
  return tactus_tap_sum(newest, taps->weights, TACTUS_ALIGN_TAPS, 0);
}

/// The output of a frame, the last but `written` - 1 of `line`, which holds the longest pad and the taps.
static inline tactus_real tactus_align_read(tactus_align* s, const tactus_line* line, int written,
                                            tactus_real period, tactus_real delay, tactus_real phase,
                                            tactus_real trigger, tactus_real on) {
  tactus_real out;
  tactus_align_follow(s, period, delay, phase, trigger, on);
  out = tactus_align_sum(&s->now, line, written);
  if (s->fading > 0) {
    const tactus_real share = (tactus_real)s->fading-- / s->fade_frames;
    out += share * (tactus_align_sum(&s->before, line, written) - out);
  }
  return out;
}
static inline tactus_real tactus_align_step(tactus_align* s, tactus_line* line, tactus_real in,
                                            tactus_real period, tactus_real delay, tactus_real phase,
                                            tactus_real trigger, tactus_real on) {
  tactus_line_write(line, in);
  return tactus_align_read(s, line, 1, period, delay, phase, trigger, on);
}
