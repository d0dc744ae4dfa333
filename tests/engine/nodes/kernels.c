/* The kernels as C: what exported code does with them. */
#include "tests/engine/nodes/kernels.h"

#include <string.h>

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
    tactus_filter state = {{1, {1, 0, 0}, {0, 0}}, {0}, {0}, {0, 0}, {0, 0}};      \
    for (int n = 0; n < frames; ++n) {                                             \
      const double radians = tactus_filter_radians(in[1][n], rate);                \
      if (n % 8 == 0) tactus_filter_set(&state, (shape));                          \
      out[n] = tactus_filter_step(&state, in[0][n], n % 8);                        \
    }                                                                              \
    return 1;                                                                      \
  } while (0)

int tactus_run_kernel(const char* node, const double* const* in, int frames, double rate, double* out) {
  if (strcmp(node, "clip") == 0) EACH_FRAME(tactus_clip(in[0][n], in[1][n], in[2][n]));
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
  if (strcmp(node, "spring") == 0) EACH_FRAME(tactus_spring_force(in[0][n], in[1][n], in[2][n]));
  if (strcmp(node, "damper") == 0) EACH_FRAME(tactus_damper_force(in[0][n], in[1][n]));
  if (strcmp(node, "wall") == 0)
    EACH_FRAME(tactus_wall_force(in[0][n], in[1][n], in[2][n], in[3][n], in[4][n]));
  if (strcmp(node, "terrain") == 0)
    EACH_FRAME(tactus_terrain_force(
        in[1][n], tactus_terrain_detent(in[0][n], tactus_max(0.0, in[2][n]), tactus_max(1e-6, in[3][n])).slope));
  return 0;
}
