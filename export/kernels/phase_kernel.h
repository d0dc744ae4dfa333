#pragma once

// Thread: [realtime].

#include "engine/dsp/filters/filter_kernel.h"
#include "engine/dsp/strings/string_kernel.h"

/// H of a design, where `delay` is z^-1.
static inline tactus_complex tactus_filter_response(const tactus_filter_design* design,
                                                    tactus_complex delay) {
  tactus_complex above = {design->b[design->order], 0}, below = {0, 0};
  for (int i = design->order; i-- > 0;) {
    above = tactus_times(above, delay);
    above.re += design->b[i];
    below.re += design->a[i];
    below = tactus_times(below, delay);
  }
  below.re = 1 - below.re;
  below.im = -below.im;
  return tactus_divided(above, below);
}

/// Phase delay of a filter at the frequency 1 / tuned [s]; 0 where tuned is not above 0.
static inline tactus_real tactus_phase_delay(tactus_filter_design design, tactus_real tuned,
                                             tactus_real rate) {
  const tactus_real frequency = 1 / tuned;
  tactus_complex one = {1, 0}, response;
  if (!(tuned > 0)) return 0;
  response = tactus_filter_response(
      &design, tactus_divided(one, tactus_turned(2 * 3.14159265358979323846 * frequency / rate)));
  return -atan2(response.im, response.re) / (2 * 3.14159265358979323846 * frequency);
}
