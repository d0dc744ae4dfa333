#pragma once

// Thread: [realtime].

#include <bit>
#include <cstdint>

#include "engine/graph/node.h"
#include "engine/graph/semantics/flat_graph.h"
#include "engine/graph/semantics/operators.h"

namespace tactus {

/// [realtime] Whether none of the operands moves.
inline bool all_rest(const Signal* in, int operands) noexcept {
  return in[0].constant() && in[1].constant() && (operands < 3 || in[2].constant());
}

/// [realtime]
void run_operation_row(Expression::Op op, const Signal* in, double* out, int frames) noexcept;
// Not inlined: its constants would delay a single frame.
[[gnu::noinline]] bool row_is_finite(const double* samples, int frames) noexcept;

/// [realtime] out[n] = op(in[0][n], in[1][n], in[2][n]), as in `evaluate`, for n in [0, frames). Of one
/// operand there are two in `in`, of three there are three.
inline void run_operation(Expression::Op op, int operands, const Signal* in, double* out,
                          int frames) noexcept {
  if (frames == 1)
    *out = evaluate(op, *in[0].data, *in[1].data, operands < 3 ? 0 : *in[2].data);
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
