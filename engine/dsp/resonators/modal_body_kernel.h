#pragma once

#include "engine/dsp/kernel.h"

// Thread: [realtime].

/// Eight modes of a body, each in a lane of a vector register; zeros are no modes. For g and R see
/// tactus_modal_body; the states are those of its text times g.
typedef struct tactus_body_modes {
  tactus_real give[8];                       ///< g
  tactus_real mass_turn[8], spring_turn[8];  ///< 2 R_m g, 2 R_k g
  tactus_real per_spring[8];                 ///< position of a mode from its spring's state
  tactus_real mass[8], spring[8];            ///< g s_m, g s_k
} tactus_body_modes;

/// A body of many modes, all of which move with the point where it is touched, behind a port of impedance Z
/// for waves of force: `a` comes in, `b` goes out,
///
///   v = sum of v_k,   F = 2 a - Z v,   b = a - Z v
///   v_k = g (F + s_m - s_k),   s_m <- 2 R_m v_k - s_m,   s_k <- 2 R_k v_k + s_k,   g = 1 / (R_m + c + R_k)
///
/// F and v of one frame depend on each other; their equation is linear and is solved once, when the body is
/// made. The stored energy, sum of (s_m^2 / R_m + s_k^2 / R_k) / (4 fs), changes in a frame by exactly
/// ((a^2 - b^2) / Z - sum of c v_k^2) / fs: a port of the same impedance may be joined to it by any delay,
/// and nothing can become unstable. Source: Bilbao, Wave and Scattering Methods for Numerical Simulation,
/// Wiley, 2004, chapter 2.
typedef struct tactus_modal_body {
  tactus_real impedance, half_frame;  ///< Z [N s/m]; [s]
  tactus_real by_wave, by_state;      ///< v = by_wave a + by_state sum of (g s_m - g s_k)
  tactus_real free_velocity;          ///< that sum
} tactus_modal_body;

/// One mode by the trapezoidal rule: R_m = 2 m fs, c, R_k = k / (2 fs) [N s/m].
typedef struct tactus_body_mode {
  tactus_real mass_ohm, loss_ohm, spring_ohm;
} tactus_body_mode;

/// Of a mass m [kg] whose mode has the pole e^(-s + 2 j w) a frame:
///
///   p = 2 fs (e^(-s + 2 j w) - 1) / (e^(-s + 2 j w) + 1),   c = -2 m Re p,   k = m |p|^2
///
/// in terms that do not cancel, with d = sinh^2 s/2 + cos^2 w:
///
///   c = 2 m fs sinh s / d,   k = 4 m fs^2 (sinh^2 s/2 + sin^2 w) / d
static inline tactus_body_mode tactus_body_mode_of(tactus_real mass, tactus_real s, tactus_real w,
                                                   tactus_real rate) {
  const tactus_real growth = sinh(s / 2), along = cos(w), across = sin(w);
  const tactus_real below = growth * growth + along * along;
  tactus_body_mode mode;
  mode.mass_ohm = 2 * mass * rate;
  mode.loss_ohm = mode.mass_ohm * (sinh(s) / below);
  mode.spring_ohm = mode.mass_ohm * ((growth * growth + across * across) / below);
  return mode;
}

/// What leaves in a frame.
typedef struct tactus_body_answer {
  tactus_real wave, velocity, force, position;
} tactus_body_answer;

/// `wave` is `a` [N]. The position follows from the modes, which step with the force.
static inline tactus_body_answer tactus_modal_body_answer(const tactus_modal_body* s, tactus_real wave) {
  tactus_body_answer answer;
  answer.velocity = tactus_fma(s->by_wave, wave, s->by_state * s->free_velocity);
  answer.wave = tactus_fma(-s->impedance, answer.velocity, wave);
  answer.force = wave + answer.wave;
  answer.position = 0;
  return answer;
}

/// `free`: sum of g s_m - g s_k, `held`: of the springs' positions, after the step. A spring's state is that
/// of half a frame later.
static inline void tactus_modal_body_close(tactus_modal_body* s, tactus_body_answer* answer, tactus_real free,
                                           tactus_real held) {
  s->free_velocity = free;
  answer->position = tactus_fma(-s->half_frame, answer->velocity, held);
}

/// One frame of a body of `count` groups of eight modes.
static inline tactus_body_answer tactus_modal_body_step(tactus_modal_body* s, tactus_body_modes* groups,
                                                        int count, tactus_real wave) {
  tactus_body_answer answer = tactus_modal_body_answer(s, wave);
  tactus_real free[8] = {0}, held[8] = {0};
  for (tactus_body_modes* m = groups; m < groups + count; ++m)
    for (int k = 0; k < 8; ++k) {
      const tactus_real v = tactus_fma(m->give[k], answer.force, m->mass[k] - m->spring[k]);
      m->mass[k] = m->mass_turn[k] * v - m->mass[k];
      m->spring[k] = tactus_fma(m->spring_turn[k], v, m->spring[k]);
      free[k] += m->mass[k] - m->spring[k];
      held[k] = tactus_fma(m->per_spring[k], m->spring[k], held[k]);
    }
  tactus_modal_body_close(s, &answer, tactus_sum_of_eight(free), tactus_sum_of_eight(held));
  return answer;
}
