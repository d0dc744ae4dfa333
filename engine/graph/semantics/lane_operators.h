#pragma once

// Thread: [realtime].

#include "engine/dsp/simd/lanes.h"
#include "engine/graph/semantics/operators.h"

namespace tactus {

/// The operators that a vector unit has, of two operands, with the bits of `Operator::value` in every lane.
template <Expression::Op kOp>
inline constexpr bool kHasLanes =
    kOp == Expression::Op::Add || kOp == Expression::Op::Subtract || kOp == Expression::Op::Multiply ||
    kOp == Expression::Op::Min || kOp == Expression::Op::Max;

/// A number for all lanes, or one for each.
inline Lanes operand_lanes(const double* at, bool same) noexcept {
  return same ? Lanes::broadcast(*at) : Lanes::load(at);
}

template <Expression::Op kOp>
Lanes lanes_of(Lanes a, Lanes b) noexcept {
  using Op = Expression::Op;
  static_assert(kHasLanes<kOp>);
  if constexpr (kOp == Op::Add) return a + b;
  if constexpr (kOp == Op::Subtract) return a - b;
  if constexpr (kOp == Op::Multiply) return a * b;
  if constexpr (kOp == Op::Min) return min(b, a);  // of equal ones, and of what is not a number, b
  if constexpr (kOp == Op::Max) return max(b, a);
}

}  // namespace tactus
