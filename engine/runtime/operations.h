#pragma once

// Thread: [realtime].

#include <bit>
#include <cstdint>

#include "engine/graph/node.h"
#include "engine/graph/semantics/expression.h"
#include "engine/graph/semantics/flat_graph.h"

namespace tactus {

/// [realtime]
void run_operation_row(Expression::Op op, const Signal* in, double* out, int frames) noexcept;
// Not inlined: its constants would delay a single frame.
[[gnu::noinline]] bool row_is_finite(const double* samples, int frames) noexcept;

/// [realtime] out[n] = op(in[0][n], in[1][n]), as in `apply`, for n
/// in [0, frames).
inline void run_operation(Expression::Op op, const Signal* in, double* out, int frames) noexcept {
  if (frames == 1)
    *out = apply(op, *in[0].data, *in[1].data);
  else
    run_operation_row(op, in, out, frames);
}

inline constexpr std::uint64_t kExponentBits = 0x7ff0000000000000u, kExponentStep = 0x0010000000000000u;

/// [realtime] On the bits: unlike a sum, this may be vectorised. A NaN or infinity has every exponent bit
/// set.
inline bool is_finite(double sample) noexcept {
  return (std::bit_cast<std::uint64_t>(sample) & kExponentBits) != kExponentBits;
}

/// [realtime] False if one of the samples is a NaN or infinite.
inline bool all_finite(const double* samples, int frames) noexcept {
  return frames == 1 ? is_finite(*samples) : row_is_finite(samples, frames);
}

/// [realtime] `frames` if there is none.
int first_nonfinite(const double* samples, int frames) noexcept;

/// [realtime] Makes NaN and infinity 0. Returns how many there were.
int clear_nonfinite(double* samples, int frames) noexcept;

}  // namespace tactus
