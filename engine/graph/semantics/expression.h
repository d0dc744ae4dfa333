#pragma once

// Thread: [any]

#include <cmath>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "engine/core/dimension.h"
#include "engine/core/error.h"
#include "engine/graph/file/value.h"

namespace tactus {

/// What a signal port is set to. `parse_expression` leaves the names for `bind_signal` to look up.
///
///   sum     = product { ("+" | "-") product }
///   product = factor { ("*" | "/") factor }
///   factor  = "-" factor | number [unit] | name | ("min" | "max") "(" sum "," sum ")" | "abs" "(" sum ")"
///           | "(" sum ")"
///
/// A unit directly follows its number ("15 ms", "2 N/m"); there it wins over a name of the same
/// letters. Its factors are joined by spaces ("N s/m") or a '/' without spaces: in "2 N / s" and "2 N * s"
/// the s is a name. A sign belongs to the number behind it, so "-34 dB" is a small gain. Names have dots:
/// "filter.low", "drum.stick.position", "system.rate".
///
/// A signal port may also hold a list of one expression for each lane, or a spread over the lanes.
struct Expression {
  enum class Op { Number, Signal, Negate, Add, Subtract, Multiply, Divide, Min, Max, Abs, Lanes, Spread };

  Op op = Op::Number;
  double number = 0;         ///< SI
  Dimension dimension = {};  ///< of a number with a unit
  bool bare = false;         ///< a number without a unit: takes the dimension that its place asks for
  bool exponential = false;  ///< Spread: along a geometric curve
  std::string name = {};     ///< Signal, as written
  int signal = -1;           ///< Signal, once its name is looked up
  std::vector<Expression> arguments = {};
  Source at = {};  ///< of this part of the text; of an operator, its sign
};

/// `at` is the place of the first character of `text` in the file. Errors: Syntax, with the column of what
/// could not be read and what was expected there.
Result<Expression> parse_expression(std::string_view text, const Source& at);

/// [a-z][a-z0-9_]*
bool is_name(std::string_view word);

/// The place of the first letter of a string: behind its quote.
Source text_start(const Value& value);

/// The operators on numbers whose result is not that of C++. A division by zero gives zero: a control at its
/// end must not make a loop fault. Minimum and maximum take `b` when `a` is not a number.
inline double divide(double a, double b) noexcept { return b == 0 ? 0 : a / b; }
inline double min(double a, double b) noexcept { return a < b ? a : b; }
inline double max(double a, double b) noexcept { return a > b ? a : b; }
inline double abs(double a) noexcept { return std::fabs(a); }

/// One operator of an expression on numbers or on intervals; what is no operator copies.
template <class Number>
Number apply(Expression::Op op, Number a, Number b) noexcept {
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
      return divide(a, b);
    case Expression::Op::Min:
      return min(a, b);
    case Expression::Op::Max:
      return max(a, b);
    case Expression::Op::Abs:
      return abs(a);
    default:
      return a;
  }
}

/// Calls `with` with the operator as a constant if it is one of kOps. False: it is none of them.
template <Expression::Op... kOps, class With>
bool for_one_of(Expression::Op op, With with) {
  return ((op == kOps && (with(std::integral_constant<Expression::Op, kOps>{}), true)) || ...);
}

/// The same for all operators, so that each gets a loop of its own. What is no operator copies.
template <class With>
void for_operator(Expression::Op op, With with) {
  using Op = Expression::Op;
  if (!for_one_of<Op::Negate, Op::Add, Op::Subtract, Op::Multiply, Op::Divide, Op::Min, Op::Max, Op::Abs>(
          op, with))
    with(std::integral_constant<Op, Op::Signal>{});
}

/// Whether it can give what is not finite although its operands are.
inline bool can_overflow(Expression::Op op) noexcept {
  return op == Expression::Op::Add || op == Expression::Op::Subtract || op == Expression::Op::Multiply ||
         op == Expression::Op::Divide;
}

}  // namespace tactus
