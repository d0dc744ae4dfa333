#pragma once

// Thread: [any].

#include <cmath>
#include <type_traits>
#include <utility>

#include "engine/graph/semantics/flat_graph.h"

namespace tactus {

/// One operator of an expression on numbers. A division by zero gives zero: a knob at its end must not make a
/// loop fault. Minimum and maximum take `b` when `a` is not a number.
inline double apply(Expression::Op op, double a, double b) noexcept {
  switch (op) {
    case Expression::Op::Negate:
      return -a;
    case Expression::Op::Add:
      return a + b;
    case Expression::Op::Subtract:
      return a - b;
    case Expression::Op::Multiply:
      return a * b;
    case Expression::Op::Divide:
      return b == 0 ? 0 : a / b;
    case Expression::Op::Min:
      return a < b ? a : b;
    case Expression::Op::Max:
      return a > b ? a : b;
    case Expression::Op::Abs:
      return std::fabs(a);
    default:
      return a;
  }
}

/// Calls `with` with the operator as a constant, so that each gets a loop of its own. What is no operator
/// copies.
template <class With>
void for_operator(Expression::Op op, With with) {
  using Op = Expression::Op;
  const auto known = [&]<Op... kOps>(std::integer_sequence<Op, kOps...>) {
    return ((op == kOps && (with(std::integral_constant<Op, kOps>{}), true)) || ...);
  };
  if (!known(std::integer_sequence<Op, Op::Negate, Op::Add, Op::Subtract, Op::Multiply, Op::Divide, Op::Min,
                                   Op::Max, Op::Abs>{}))
    with(std::integral_constant<Op, Op::Signal>{});
}

/// Whether it can give what is not finite although its operands are.
inline bool can_overflow(Expression::Op op) noexcept {
  return op == Expression::Op::Add || op == Expression::Op::Subtract || op == Expression::Op::Multiply ||
         op == Expression::Op::Divide;
}

}  // namespace tactus
