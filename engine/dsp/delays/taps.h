#pragma once

// Thread: [realtime].

#include <array>
#include <cstddef>

#include "engine/dsp/simd/lanes.h"

namespace tactus {

/// Sum over k of weight[k] * newest[-k] in two chains, even and odd taps, so that a single frame waits for
/// half the additions. `start` is what the sum starts from.
template <std::size_t Count>
double tap_sum(const double* newest, const std::array<double, Count>& weight, double start) noexcept {
  double even = fused_multiply_add(weight[0], newest[0], start), odd = 0;
  if constexpr (Count > 1) odd = weight[1] * *(newest - 1);
  for (std::size_t k = 2; k < Count; ++k) {
    double& chain = k % 2 == 0 ? even : odd;
    chain = fused_multiply_add(weight[k], *(newest - k), chain);
  }
  return even + odd;
}

/// The same for `frames` frames in a row: y[n] = start[n] + sum of weight[k] * newest[n - k], with the same
/// bits. `start` may be nullptr for 0. `y` overlaps nothing.
template <std::size_t Count>
void tap_sums(const double* newest, const std::array<double, Count>& weight, const double* start, double* y,
              int frames) noexcept {
  int n = 0;
  for (; n + Lanes::kCount <= frames; n += Lanes::kCount) {
    const double* at = newest + n;
    auto even = fused_multiply_add(Lanes::broadcast(weight[0]), Lanes::load(at),
                                   start != nullptr ? Lanes::load(start + n) : Lanes::broadcast(0));
    auto odd = Lanes::broadcast(0);
    if constexpr (Count > 1) odd = Lanes::broadcast(weight[1]) * Lanes::load(at - 1);
    for (std::size_t k = 2; k < Count; ++k) {
      auto& chain = k % 2 == 0 ? even : odd;
      chain = fused_multiply_add(Lanes::broadcast(weight[k]), Lanes::load(at - k), chain);
    }
    (even + odd).store(y + n);
  }
  for (; n < frames; ++n) y[n] = tap_sum(newest + n, weight, start != nullptr ? start[n] : 0);
}

}  // namespace tactus
