#pragma once

// Thread: [realtime].

#include "engine/dsp/kernel.h"

// Sums of a triangular matrix, as engine/physics/solvers/triangular_sweep.h adds them: so many columns at a
// time, each to a sum of its own.

/// One row: `x` in the places of `slots` times the values, and the inverse behind them.
static inline void tactus_sweep_one(const tactus_real* values, const int* slots, int columns,
                                    const tactus_real* x, tactus_real* to) {
  tactus_real a = *to, b = 0, c = 0, d = 0;
  int i = 0;
  for (; i + 4 <= columns; i += 4) {
    a = tactus_fma(values[i], x[slots[i]], a);
    b = tactus_fma(values[i + 1], x[slots[i + 1]], b);
    c = tactus_fma(values[i + 2], x[slots[i + 2]], c);
    d = tactus_fma(values[i + 3], x[slots[i + 3]], d);
  }
  for (; i < columns; ++i) a = tactus_fma(values[i], x[slots[i]], a);
  *to = ((a + b) + (c + d)) * values[columns];
}

/// Eight rows and their inverse, by columns, the number of which is a multiple of four.
static inline void tactus_sweep_eight(const tactus_real* values, const int* slots, int columns,
                                      const tactus_real* x, tactus_real* to) {
  tactus_real right[8];
  for (int lane = 0; lane < 8; ++lane) {
    const tactus_real* v = values + lane;
    tactus_real a = to[lane], b = 0, c = 0, d = 0;
    for (int i = 0; i < columns; i += 4) {
      a = tactus_fma(v[8 * i], x[slots[i]], a);
      b = tactus_fma(v[8 * i + 8], x[slots[i + 1]], b);
      c = tactus_fma(v[8 * i + 16], x[slots[i + 2]], c);
      d = tactus_fma(v[8 * i + 24], x[slots[i + 3]], d);
    }
    right[lane] = (a + b) + (c + d);
  }
  for (int lane = 0; lane < 8; ++lane) {
    const tactus_real* v = values + 8 * columns + lane;
    tactus_real a = 0, b = 0, c = 0, d = 0;
    for (int i = 0; i < 8; i += 4) {
      a = tactus_fma(v[8 * i], right[i], a);
      b = tactus_fma(v[8 * i + 8], right[i + 1], b);
      c = tactus_fma(v[8 * i + 16], right[i + 2], c);
      d = tactus_fma(v[8 * i + 24], right[i + 3], d);
    }
    to[lane] = (a + b) + (c + d);
  }
}
