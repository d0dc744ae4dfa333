/* The kernels as C: what exported code does with them. */
#include "tests/engine/nodes/kernels.h"

#include <string.h>

#define MODES 51
#define GROUPS ((MODES + 7) / 8) /* 7: four, two and one are stepped together */
#define LOWEST_PITCH 10.0
#define TAPS TACTUS_STRING_TAPS /* the most that are read in a row */
#define NO_FILTER {{1, {1, 0, 0}, {0, 0}}, {0}, {0}, {0, 0}, {0, 0}}

#include "kernels_c99.h" /* every *_kernel.h, made by CMake */

/* One statement for each frame. */
#define EACH_FRAME(value) \
  do {                    \
    for (int n = 0; n < frames; ++n) out[n] = (value); \
    return 1;             \
  } while (0)

/* A filter, the cutoff of which is input 1. */
#define EACH_FILTERED(shape)                                                       \
  do {                                                                             \
    tactus_filter state = NO_FILTER;                                               \
    for (int n = 0; n < frames; ++n) {                                             \
      const double radians = tactus_filter_radians(in[1][n], rate);                \
      if (n % 8 == 0) tactus_filter_set(&state, (shape));                          \
      out[n] = tactus_filter_step(&state, state.design.order, in[0][n], n % 8);    \
    }                                                                              \
    return 1;                                                                      \
  } while (0)

static double clamped(double x, double low, double high) { return x > low ? tactus_min(x, high) : low; }

static int run_fir(const double* in, int frames, double* out) {
  static const double taps[8] = {0, 0, 0, 0, 0, 0.5, -0.25, 1}; /* of [1, -0.25, 0.5] */
  for (int n = 0; n < frames; ++n) {
    double inputs[8] = {0};
    for (int k = 0; k < 8 && k <= n; ++k) inputs[7 - k] = in[n - k];
    out[n] = tactus_fir_frame(taps, 8, inputs);
  }
  return 1;
}

/* Harmonic modes; those of the last group that are not used stay silent. */
static int run_modal(const double* const* in, int frames, double rate, double* out) {
  static tactus_modes groups[GROUPS];
  memset(groups, 0, sizeof groups);
  for (int k = 0; k < 8 * GROUPS; ++k) tactus_modes_set(&groups[k / 8], k % 8, tactus_mode_design(0, 1, 0, 1));
  for (int n = 0; n < frames; ++n) {
    for (int k = 0; n % 8 == 0 && k < MODES; ++k) {
      const double frequency = clamped(in[1][n], 1, 1e6) * (k + 1);
      const double decay = clamped(in[2][n], 1e-4, 1e4) * (pow(1.0 / (k + 1), 0.5) / 1.0);
      tactus_modes_set(&groups[k / 8], k % 8, tactus_mode_design(frequency, decay, 1, rate));
    }
    out[n] = tactus_modal_step(groups, GROUPS, n == 0 ? 0.0 : in[0][n - 1]);
  }
  return 1;
}

/* Harmonic modes of 220 Hz, 0.1 s and 1 kg at a port of 2 N s/m. */
static int run_modal_body(const double* in, int frames, double rate, double* out) {
  static tactus_body_modes groups[GROUPS];
  const double pi = 3.141592653589793;
  tactus_modal_body body = {0};
  double give = 0;
  memset(groups, 0, sizeof groups);
  for (int k = 0; k < MODES; ++k) {
    const double sigma = 3 * 2.302585092994046 / (0.1 * (pow(1.0 / (k + 1), 0.5) / 1.0));
    const tactus_body_mode mode = tactus_body_mode_of(1, sigma / rate, pi * (220.0 * (k + 1)) / rate, rate);
    const double g = 1 / (mode.mass_ohm + mode.loss_ohm + mode.spring_ohm);
    tactus_body_modes* group = &groups[k / 8];
    group->give[k % 8] = g;
    group->mass_turn[k % 8] = 2 * mode.mass_ohm * g;
    group->spring_turn[k % 8] = 2 * mode.spring_ohm * g;
    give += g;
  }
  body.impedance = 2;
  body.by_state = 1 / (1 + 2 * give);
  body.by_wave = 2 * give * body.by_state;
  for (int n = 0; n < frames; ++n) out[n] = tactus_modal_body_step(&body, groups, GROUPS, in[n]).wave;
  return 1;
}

static int run_align(const double* const* in, int frames, double rate, double* out) {
  static double samples[16384 + TAPS];
  tactus_line line = {samples, 16384, TAPS, 0};
  tactus_align state;
  memset(samples, 0, sizeof samples);
  memset(&state, 0, sizeof state);
  tactus_align_start(&state, rate, TACTUS_ALIGN_LONGEST);
  EACH_FRAME(tactus_align_step(&state, &line, in[0][n], in[1][n], in[2][n], in[3][n], in[4][n], in[5][n]));
}

/* Cubic, of times up to 10 ms. */
static int run_delay(const double* const* in, int frames, double rate, double* out) {
  static double samples[1024 + TAPS];
  const tactus_delay delay = tactus_delay_between(0, 0.01, rate);
  tactus_line line = {samples, 1024, TAPS, 0};
  memset(samples, 0, sizeof samples);
  EACH_FRAME(tactus_delay_step(&delay, 3, &line, in[0][n], in[1][n]));
}

/* With losses by a zero. */
static int run_string(const double* const* in, int frames, double rate, double* out) {
  static double samples[8192 + TAPS];
  const tactus_string_kind kind = {0, 0.9999, 0};
  tactus_line line = {samples, 8192, TAPS, 0};
  tactus_string_design design = {0, {0}, 0};
  memset(samples, 0, sizeof samples);
  for (int n = 0; n < frames; ++n) {
    if (n % 8 == 0) design = tactus_string(kind, tactus_max(LOWEST_PITCH, in[1][n]), in[2][n], in[3][n], rate);
    out[n] = tactus_string_step(&design, 0, &line, 0, in[0][n], n % 8);
  }
  return 1;
}

/* Free at its end, with losses by a pole. */
static int run_waveguide(const double* const* in, int frames, double rate, double* out) {
  static double samples[8192 + TAPS];
  const tactus_waveguide guide = tactus_waveguide_between(LOWEST_PITCH, 5000, 1, 0, rate);
  tactus_line line = {samples, 8192, TAPS, 0};
  tactus_string_design design = {0, {0}, 0};
  tactus_filter pole = NO_FILTER;
  memset(samples, 0, sizeof samples);
  for (int n = 0; n < frames; ++n) {
    if (n % 8 == 0) {
      design = tactus_waveguide_design(&guide, in[1][n], in[2][n], in[3][n]);
      tactus_string_set_pole(&pole, &design);
    }
    out[n] = tactus_waveguide_step(&design, 1, &line, &pole, in[0][n], n % 8);
  }
  return 1;
}

static int run_onset(const double* const* in, int frames, double rate, double* out) {
  tactus_onset state;
  memset(&state, 0, sizeof state);
  tactus_onset_start(&state, rate, 30, 0.020, 0.028);
  EACH_FRAME(tactus_onset_step(&state, in[0][n], in[1][n], in[2][n], in[3][n], in[4][n]));
}

static int run_stroke(const double* const* in, int frames, double rate, double* out) {
  tactus_stroke state;
  memset(&state, 0, sizeof state);
  tactus_stroke_start(&state, rate, &tactus_stroke_nets[1]);
  EACH_FRAME(tactus_stroke_step(&state, in[0][n], in[1][n], in[2][n], in[3][n], 1));
}

/* Starts over at each trigger; waits for the first one. */
static int run_curve(const double* const* in, int frames, double* out) {
  static const double x[] = {0, 96, 480}, y[] = {0.25, 1, -1};
  const tactus_curve curve = {3, x, y, 0};
  tactus_curve_run run = {{0}, 0, 0, 0, 0};
  for (int n = 0; n < frames; ++n) {
    const double place = tactus_curve_run_step(&run, in[0][n], in[1][n], in[2][n], 1);
    out[n] = run.level * tactus_curve_value(&curve, TACTUS_CURVE_LINEAR, place);
  }
  return 1;
}

static int run_state(const double* const* in, int frames, double* out) {
  tactus_state state = {{0}, 0, 0};
  for (int n = 0; n < frames; ++n) {
    out[n] = tactus_state_value(&state, in[2][n]);
    tactus_state_take(&state, in[0][n], in[1][n]);
  }
  return 1;
}

static int run_interval(const double* const* in, int frames, double rate, double* out) {
  tactus_interval state = {{0}, 0, 0};
  for (int n = 0; n < frames; ++n) {
    out[n] = tactus_interval_value(&state, in[1][n], rate);
    tactus_interval_pass(&state, in[0][n]);
  }
  return 1;
}

/* The x of the tip of an arm, whose sizes come after its angles and its loads. */
static int run_arm(tactus_arm_pose (*pose)(tactus_arm_angles, tactus_arm_sizes), const double* const* in,
                   int joints, int loads, int count, int frames, double* out) {
  for (int n = 0; n < frames; ++n) {
    tactus_arm_angles angles = {{0}};
    tactus_arm_sizes sizes = {{0}};
    for (int i = 0; i < joints; ++i) angles.of[i] = in[i][n];
    for (int i = 0; i < count; ++i) sizes.of[i] = in[joints + loads + i][n];
    out[n] = pose(angles, sizes).tip[0];
  }
  return 1;
}

/* A plane. */
static int run_proxy(const double* const* in, int frames, double* out) {
  tactus_proxy state = {{0}, 0, 0, 0};
  for (int n = 0; n < frames; ++n) {
    double device[3], numbers[7];
    for (int i = 0; i < 3; ++i) device[i] = in[i][n] - in[5 + i][n];
    for (int i = 0; i < 7; ++i) numbers[i] = in[8 + i][n];
    {
      const tactus_solid solid = tactus_solid_of(TACTUS_SOLID_PLANE, numbers, 0, 1, 2);
      out[n] = tactus_proxy_step(&state, &solid, device, in[3][n], in[4][n]).force[0];
    }
  }
  return 1;
}

static int run_actuator_inverse(const double* const* in, int frames, double rate, double* out) {
  tactus_actuator_inverse state = {{0, 0}, {0, 0}, {0, 0, 0}, 0, 0};
  for (int n = 0; n < frames; ++n) {
    const tactus_actuator actuator = {in[1][n], in[2][n], in[3][n], in[4][n], in[5][n], in[6][n]};
    out[n] = tactus_actuator_inverse_step(&state, in[0][n], &actuator, in[7][n], in[8][n], rate);
  }
  return 1;
}

static int run_event_delay(const double* const* in, int frames, double rate, double* out) {
  static tactus_event_delay state;
  memset(&state, 0, sizeof state);
  for (int n = 0; n < frames; ++n)
    out[n] = tactus_event_delay_step(&state, in[0][n], clamped(in[1][n], 0, 3600) * rate, in[2][n]);
  return 1;
}

static int run_sample(const double* const* in, int frames, double* out) {
  static const double samples[] = {0.5, -0.25, 0.125, 0};
  tactus_sample state = {{0}, 0, 0};
  for (int n = 0; n < frames; ++n) {
    if (tactus_rise_step(&state.rise, in[0][n])) tactus_sample_start(&state);
    out[n] = in[2][n] * tactus_sample_read(&state, samples, 4, tactus_clamp(in[1][n], 0.0, 1000.0), 1);
  }
  return 1;
}

int tactus_run_kernel(const char* node, const double* const* in, int frames, double rate, double* out) {
  if (strcmp(node, "clip") == 0) EACH_FRAME(tactus_clip(in[0][n], in[1][n], in[2][n]));
  if (strcmp(node, "fir") == 0) return run_fir(in[0], frames, out);
  if (strcmp(node, "modal") == 0) return run_modal(in, frames, rate, out);
  if (strcmp(node, "modal_body") == 0) return run_modal_body(in[0], frames, rate, out);
  if (strcmp(node, "align") == 0) return run_align(in, frames, rate, out);
  if (strcmp(node, "delay") == 0) return run_delay(in, frames, rate, out);
  if (strcmp(node, "string") == 0) return run_string(in, frames, rate, out);
  if (strcmp(node, "waveguide") == 0) return run_waveguide(in, frames, rate, out);
  if (strcmp(node, "onset") == 0) return run_onset(in, frames, rate, out);
  if (strcmp(node, "stroke") == 0) return run_stroke(in, frames, rate, out);
  if (strcmp(node, "curve") == 0) return run_curve(in, frames, out);
  if (strcmp(node, "state") == 0) return run_state(in, frames, out);
  if (strcmp(node, "interval") == 0) return run_interval(in, frames, rate, out);
  if (strcmp(node, "two_link") == 0) return run_arm(tactus_two_link, in, 2, 2, 2, frames, out);
  if (strcmp(node, "five_bar") == 0) return run_arm(tactus_five_bar, in, 2, 2, 3, frames, out);
  if (strcmp(node, "delta") == 0) return run_arm(tactus_delta, in, 3, 3, 3, frames, out);
  if (strcmp(node, "six_axis") == 0) return run_arm(tactus_six_axis, in, 6, 6, 6, frames, out);
  if (strcmp(node, "proxy") == 0) return run_proxy(in, frames, out);
  if (strcmp(node, "actuator_inverse") == 0) return run_actuator_inverse(in, frames, rate, out);
  if (strcmp(node, "event_delay") == 0) return run_event_delay(in, frames, rate, out);
  if (strcmp(node, "sample") == 0) return run_sample(in, frames, out);
  if (strcmp(node, "wavetable") == 0) {
    static const double table[] = {0, 1, 0.5, -0.5, -1};
    tactus_phasor state = {0};
    EACH_FRAME(tactus_wavetable_step(&state, table, 5, 0, in[0][n], in[1][n], in[2][n], rate));
  }
  if (strcmp(node, "map") == 0) {
    static const double x[] = {-1, 0.25, 1}, y[] = {3, -1, 2};
    const tactus_curve curve = {3, x, y, 0};
    EACH_FRAME(tactus_curve_value(&curve, TACTUS_CURVE_LINEAR, in[0][n]));
  }
  if (strcmp(node, "mix") == 0) {
    double lane;
    EACH_FRAME((lane = in[0][n], tactus_mix(&lane, 1)));
  }
  if (strcmp(node, "hysteresis") == 0) {
    tactus_hysteresis state = {0};
    EACH_FRAME(tactus_hysteresis_step(&state, in[0][n], in[1][n]));
  }
  if (strcmp(node, "quantiser") == 0) EACH_FRAME(tactus_quantise_nearest(in[0][n], in[1][n]));
  if (strcmp(node, "slew") == 0) {
    tactus_slew state = {0};
    EACH_FRAME(tactus_slew_step(&state, in[0][n], in[1][n], in[2][n], 1 / rate));
  }
  if (strcmp(node, "latch") == 0) {
    tactus_latch state = {{0}, {0}, 0};
    EACH_FRAME(tactus_latch_step(&state, in[0][n], in[1][n]));
  }
  if (strcmp(node, "counter") == 0) {
    tactus_counter state = {{0}, {0}, 0};
    EACH_FRAME(tactus_counter_step(&state, in[0][n], in[1][n], in[2][n]));
  }
  if (strcmp(node, "sample_hold") == 0) {
    tactus_sample_hold state = {{0}, 0};
    EACH_FRAME(tactus_sample_hold_step(&state, in[0][n], in[1][n]));
  }
  if (strcmp(node, "threshold") == 0) {
    tactus_threshold state = {0, 0, 0};
    EACH_FRAME(tactus_threshold_step(&state, in[0][n], in[1][n], tactus_max(0.0, in[2][n]),
                                     tactus_clamp(in[3][n], 0.0, 3600.0) * rate));
  }
  if (strcmp(node, "decay") == 0) {
    tactus_decay state = {{0}, {0, 0}, {0, 0}};
    EACH_FRAME(tactus_decay_step(&state, in[0][n], in[1][n], in[2][n], in[3][n], rate));
  }
  if (strcmp(node, "adsr") == 0) {
    tactus_adsr state = {0, 0, 0, {0, 0}, {0, 0}};
    EACH_FRAME(tactus_adsr_step(&state, in[0][n], in[1][n], in[2][n], in[3][n], in[4][n], rate));
  }
  if (strcmp(node, "envelope") == 0) {
    tactus_follower state = {0};
    EACH_FRAME(tactus_follower_step(&state, in[0][n], tactus_keep(in[1][n], rate), tactus_keep(in[2][n], rate)));
  }
  if (strcmp(node, "difference") == 0) {
    tactus_difference state = {0};
    EACH_FRAME(tactus_difference_step(&state, in[0][n], rate));
  }
  if (strcmp(node, "one_pole") == 0) EACH_FILTERED(tactus_one_pole(radians));
  if (strcmp(node, "dc_blocker") == 0) EACH_FILTERED(tactus_dc_blocker(radians));
  if (strcmp(node, "velocity") == 0) EACH_FILTERED(tactus_filtered_velocity(radians, rate));
  if (strcmp(node, "low_pass") == 0) EACH_FILTERED(tactus_low_pass(radians, tactus_filter_q(in[2][n])));
  if (strcmp(node, "high_pass") == 0) EACH_FILTERED(tactus_high_pass(radians, tactus_filter_q(in[2][n])));
  if (strcmp(node, "band_pass") == 0) EACH_FILTERED(tactus_band_pass(radians, tactus_filter_q(in[2][n])));
  if (strcmp(node, "noise") == 0) {
    const tactus_noise_bits key = tactus_noise_key(1, 0);
    EACH_FRAME(in[0][n] * tactus_noise_uniform(key, (tactus_noise_bits)n));
  }
  if (strcmp(node, "sine") == 0) {
    tactus_phasor state = {0};
    EACH_FRAME(tactus_sine_step(&state, in[0][n], in[1][n], in[2][n], rate));
  }
  if (strcmp(node, "clock") == 0) {
    tactus_clock state = {{0}, 0, 0, 0, 0, 0};
    EACH_FRAME(tactus_clock_step(&state, in[0][n] * in[1][n], in[2][n], in[3][n], rate));
  }
  if (strcmp(node, "sequence") == 0) {
    static const double values[] = {1, 0.5, -2};
    tactus_sequence state = {{0}, {0}, 0};
    EACH_FRAME((tactus_sequence_step(&state, in[0][n], in[1][n], values, 3), values[tactus_sequence_index(&state)]));
  }
  if (strcmp(node, "pitch") == 0) {
    static double full[8000], small[8000]; /* of 100 Hz and more */
    tactus_pitch state;
    double held = 0;
    memset(&state, 0, sizeof state);
    memset(full, 0, sizeof full);
    memset(small, 0, sizeof small);
    tactus_pitch_start(&state, rate, 100, 1000);
    EACH_FRAME((tactus_pitch_step(&state, full, small, in[0][n]),
                held = state.clarity >= in[1][n] && state.clarity > 0 ? state.frequency : held));
  }
  if (strcmp(node, "poly") == 0) {
    tactus_voice voices[1] = {{0, 0, 0, 0, 0}};
    tactus_poly state = {{0}, {0}, 0};
    EACH_FRAME((tactus_poly_step(&state, voices, 1, 1, in[1][n], in[2][n], in[0][n], in[3][n]), voices[0].starts));
  }
  if (strcmp(node, "crossfade") == 0) EACH_FRAME(tactus_crossfade(in[0][n], in[1][n], in[2][n], 0));
  if (strcmp(node, "random_walk") == 0) {
    const tactus_noise_bits key = tactus_noise_key(1, 0);
    tactus_random_walk state = {0};
    EACH_FRAME(in[1][n] * tactus_random_walk_step(&state, key, (tactus_noise_bits)n, in[0][n], rate));
  }
  if (strcmp(node, "shaper") == 0) {
    tactus_shaper state = {0, 0};
    EACH_FRAME(tactus_shaper_step(&state, in[0][n], in[1][n], in[2][n], TACTUS_SHAPE_TANH));
  }
  if (strcmp(node, "spring") == 0) EACH_FRAME(tactus_spring_force(in[0][n], in[1][n], in[2][n]));
  if (strcmp(node, "damper") == 0) EACH_FRAME(tactus_damper_force(in[0][n], in[1][n]));
  if (strcmp(node, "wall") == 0)
    EACH_FRAME(tactus_wall_force(in[0][n], in[1][n], in[2][n], in[3][n], in[4][n]));
  if (strcmp(node, "terrain") == 0)
    EACH_FRAME(tactus_terrain_force(
        in[1][n], tactus_terrain_detent(in[0][n], tactus_max(0.0, in[2][n]), tactus_max(1e-6, in[3][n])).slope));
  return 0;
}
