#pragma once

// Thread: [realtime].

#include "engine/dsp/envelopes/envelope_kernel.h"
#include "engine/nodes/generators/oscillator_kernel.h"

// Waves with jumps and corners, without audible aliases. Each is the ideal wave convolved with the cubic
// B-spline of four frames,
//   b(t) = 2/3 - t^2 + |t|^3 / 2  for |t| < 1,   (2 - |t|)^3 / 6  for 1 <= |t| < 2,   t in frames,
// and then sampled: partial k has its ideal amplitude times sinc(k f / rate)^4, and so have the aliases of
// the partials above half the rate, which this suppresses. As b >= 0, the wave stays within those of the
// ideal one. Source: Valimaki, Pekonen & Nam, J. Acoust. Soc. Am. 131, 2012 (polynomial band-limited steps).

/// What b holds beyond t frames, t >= 0:  integral of b from t on.
static inline tactus_real tactus_spline_tail(tactus_real t) {
  const tactus_real rest = 2.0 - t;
  if (t >= 2) return 0.0;
  if (t >= 1) return rest * rest * rest * rest / 24.0;
  return 0.5 - t * (2.0 / 3.0 - t * t * (1.0 / 3.0 - t / 8.0));
}

/// The integral of the tail from t frames on, t >= 0.
static inline tactus_real tactus_spline_tail_integral(tactus_real t) {
  const tactus_real rest = 2.0 - t;
  if (t >= 2) return 0.0;
  if (t >= 1) return rest * rest * rest * rest * rest / 120.0;
  return 7.0 / 30.0 - t * (0.5 - t * (1.0 / 3.0 - t * t * (1.0 / 12.0 - t / 40.0)));
}

/// 2 turns - 1, with a jump of -2 at whole turns. 0 <= turns < 1; `step` turns a frame, 0 to 0.5.
static inline tactus_real tactus_saw_at(tactus_real turns, tactus_real step) {
  // At the jump itself it is halfway, also where nothing moves.
  tactus_real out = turns > 0 ? 2.0 * turns - 1.0 : 0.0;
  for (tactus_real past = turns > 0 ? turns : 1.0; past < 2.0 * step; past += 1.0)
    out += 2.0 * tactus_spline_tail(past / step);
  for (tactus_real next = 1.0 - turns; next < 2.0 * step; next += 1.0)
    out -= 2.0 * tactus_spline_tail(next / step);
  return out;
}

/// What corners at whole turns, where the slope grows by 1 a frame, add to a wave.
static inline tactus_real tactus_corner_at(tactus_real turns, tactus_real step) {
  tactus_real out = 0.0;
  for (tactus_real past = turns; past < 2.0 * step; past += 1.0)
    out += tactus_spline_tail_integral(past / step);
  for (tactus_real next = 1.0 - turns; next < 2.0 * step; next += 1.0)
    out += tactus_spline_tail_integral(next / step);
  return out;
}

/// Into [0, 1).
static inline tactus_real tactus_whole_turns_off(tactus_real turns) {
  const tactus_real rest = turns - floor(turns);
  return rest < 1 ? rest : 0.0;
}

/// The step in turns a frame, at most half a turn either way.
static inline tactus_real tactus_turns_a_frame(tactus_real frequency, tactus_real rate) {
  return tactus_clamp(frequency / rate, -0.5, 0.5);
}

/// The running phase with an offset in radians, and its step.
typedef struct tactus_wave_phase {
  tactus_real turns, step;
} tactus_wave_phase;

static inline tactus_wave_phase tactus_wave_phase_step(tactus_phasor* s, tactus_real frequency,
                                                       tactus_real phase, tactus_real rate) {
  tactus_wave_phase now;
  now.step = tactus_turns_a_frame(frequency, rate);
  now.turns = tactus_whole_turns_off(tactus_phasor_step(s, now.step) + phase / 6.283185307179586);
  now.step = fabs(now.step);
  return now;
}

/// Frequency in Hz, phase in radians.
static inline tactus_real tactus_saw_step(tactus_phasor* s, tactus_real frequency, tactus_real phase,
                                          tactus_real level, tactus_real rate) {
  const tactus_wave_phase now = tactus_wave_phase_step(s, frequency, phase, rate);
  return level * tactus_saw_at(now.turns, now.step);
}

/// High for `width` of each period, 0 to 1: the difference of two saws.
static inline tactus_real tactus_square_step(tactus_phasor* s, tactus_real frequency, tactus_real phase,
                                             tactus_real level, tactus_real width, tactus_real rate) {
  const tactus_wave_phase now = tactus_wave_phase_step(s, frequency, phase, rate);
  const tactus_real share = tactus_clamp(width, 0.0, 1.0);
  const tactus_real late = tactus_whole_turns_off(now.turns - share);
  if (share <= 0 || share >= 1) return share > 0 ? level : -level;
  return level * (tactus_saw_at(late, now.step) - tactus_saw_at(now.turns, now.step) + 2.0 * share - 1.0);
}

/// Corners at a quarter and three quarters of a period, where the slope changes by 8 a turn.
static inline tactus_real tactus_triangle_step(tactus_phasor* s, tactus_real frequency, tactus_real phase,
                                               tactus_real level, tactus_real rate) {
  const tactus_wave_phase now = tactus_wave_phase_step(s, frequency, phase, rate);
  const tactus_real after_low = tactus_whole_turns_off(now.turns + 0.25);
  const tactus_real after_high = tactus_whole_turns_off(now.turns + 0.75);
  const tactus_real corners = tactus_corner_at(after_low, now.step) - tactus_corner_at(after_high, now.step);
  return level * (1.0 - 4.0 * fabs(after_low - 0.5) + 8.0 * now.step * corners);
}

/// The phase itself, 0 to below 1; a trigger at `reset` starts it again at 0.
typedef struct tactus_resettable_phasor {
  tactus_phasor phasor;
  tactus_rise reset;
} tactus_resettable_phasor;

static inline tactus_real tactus_phasor_reset_step(tactus_resettable_phasor* s, tactus_real frequency,
                                                   tactus_real phase, tactus_real reset, tactus_real rate) {
  if (tactus_rise_step(&s->reset, reset)) s->phasor.turns = 0;
  return tactus_whole_turns_off(tactus_phasor_step(&s->phasor, frequency / rate) + phase / 6.283185307179586);
}
