#pragma once

#include <cmath>

#include "engine/graph/semantics/flat_graph.h"

namespace tactus {

/// One operator of an expression on numbers. A division by zero gives zero: a knob at its end must not make a
/// loop fault. Minimum and maximum take `b` when `a` is not a number.
inline double apply(Term::Op op, double a, double b) noexcept {
  switch (op) {
    case Term::Op::Negate:
      return -a;
    case Term::Op::Add:
      return a + b;
    case Term::Op::Subtract:
      return a - b;
    case Term::Op::Multiply:
      return a * b;
    case Term::Op::Divide:
      return b == 0 ? 0 : a / b;
    case Term::Op::Min:
      return a < b ? a : b;
    case Term::Op::Max:
      return a > b ? a : b;
    case Term::Op::Abs:
      return std::fabs(a);
    default:
      return a;
  }
}

/// Whether it can give what is not finite although its operands are.
inline bool can_overflow(Term::Op op) noexcept {
  return op == Term::Op::Add || op == Term::Op::Subtract || op == Term::Op::Multiply ||
         op == Term::Op::Divide;
}

}  // namespace tactus
