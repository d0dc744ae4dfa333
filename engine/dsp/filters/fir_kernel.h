#pragma once

#include "engine/dsp/kernel.h"

// Thread: [realtime].

#define TACTUS_FIR_SUMS 8

static inline tactus_real tactus_fir_total(const tactus_real* s) {
  return ((s[0] + s[1]) + (s[2] + s[3])) + ((s[4] + s[5]) + (s[6] + s[7]));
}

/// y[n] = sum over k of taps[k] x[n-k], straight from the definition: no delay of its own, one multiply-add a
/// tap. Eight sums, of every eighth tap each, are added up at the end. `taps`: the last one first, with zeros
/// before it so that `count` is a multiple of eight; `oldest`: the input that the first of them is for, which
/// the others follow.
static inline tactus_real tactus_fir_frame(const tactus_real* taps, int count, const tactus_real* oldest) {
  tactus_real sums[TACTUS_FIR_SUMS] = {0};
  for (int k = 0; k < count; ++k) {
    tactus_real* sum = sums + k % TACTUS_FIR_SUMS;
    *sum = tactus_fma(taps[k], oldest[k], *sum);
  }
  return tactus_fir_total(sums);
}
