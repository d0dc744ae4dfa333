#pragma once

// Thread: [realtime].

#include <math.h>

// What kernels are written with. A kernel is the step of a node as text that compiles as C99 and
// as C++20: structs of state, all zero at the start, and `static inline` functions over one number type. It
// allocates nothing and calls nothing but <math.h> and the functions below; the vectorised forms beside it
// give the same bits. `*_kernel.h` files include only kernels; tests/engine/nodes/kernels_test.cpp compiles
// them as C.

typedef double tactus_real;

/// As std::max, std::min and std::clamp, also for NaN.
static inline tactus_real tactus_max(tactus_real a, tactus_real b) { return a < b ? b : a; }
static inline tactus_real tactus_min(tactus_real a, tactus_real b) { return b < a ? b : a; }
static inline tactus_real tactus_clamp(tactus_real x, tactus_real low, tactus_real high) {
  return x < low ? low : high < x ? high : x;
}
static inline int tactus_is_finite(tactus_real x) { return x - x == 0; }

/// As Lanes::sum: added in halves, k and k + 4, k and k + 2, k and k + 1.
static inline tactus_real tactus_sum_of_eight(const tactus_real* x) {
  return ((x[0] + x[4]) + (x[2] + x[6])) + ((x[1] + x[5]) + (x[3] + x[7]));
}

/// a * b + c, rounded once where the machine has the instruction (see engine/core/realtime.h).
static inline tactus_real tactus_fma(tactus_real a, tactus_real b, tactus_real c) {
#if defined(__FMA__) || defined(__aarch64__)
  return __builtin_fma(a, b, c);
#else
  return a * b + c;
#endif
}
