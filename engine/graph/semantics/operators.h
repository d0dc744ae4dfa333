#pragma once

// Thread: [any]; `value` and what calls it also [realtime].

#include <array>
#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>

#include "engine/core/index.h"
#include "engine/core/math_functions.h"
#include "engine/core/units.h"
#include "engine/graph/semantics/expression.h"
#include "engine/graph/semantics/interval.h"

namespace tactus {

inline constexpr std::size_t kMostOperands = 3;
using OperandValues = std::array<double, kMostOperands>;
using OperandRanges = std::array<Interval, kMostOperands>;

/// What `tactus check` makes of an operator in a loop.
enum class SmallSignal {
  Linear,    ///< the same slope everywhere
  Product,   ///< linear in each operand
  Quotient,  ///< linear in the first operand
  Corner,    ///< minimum, maximum, absolute value: straight lines that meet
  Bounded,   ///< a curve whose slope is limited: its steepest place is searched
  Curved,    ///< a curve whose slope is not: linearised at the operating point
  Event,     ///< it steps: event-driven, no small-signal gain exists
  Choice,    ///< the first operand, event-driven, chooses which of the others passes
};

/// One operator or function of expressions, and everything that is known about it.
struct Operator {
  Expression::Op op;
  const char* name;            ///< "sin"; of an operator without brackets its sign
  const char* arguments = "";  ///< "y, x": how messages show its use; "": no function
  int operands = 1;

  /// The unit of each operand: u the same for all that have one, 1 a plain number, ? any. The unit of the
  /// result: u, 1, * or / the product or quotient of both, r the square root of the operand's, p its power by
  /// the second operand.
  const char* operand_units = "1";
  char unit = '1';

  /// What executes it and folds constants. nullptr: its `definition` replaces it, where a, b and c are the
  /// operands.
  double (*value)(double a, double b, double c) noexcept = nullptr;
  const char* definition = nullptr;
  bool can_fail = false;  ///< the result can be non-finite although the operands are finite

  /// Outside its domain the result is not finite. The domain is an interval of the first operand, with its
  /// ends or without them; where that does not describe it, `outside` is true if no operands of these ranges
  /// are inside.
  const char* domain_text = "";  ///< "x > 0"; "" if all numbers are inside
  Interval domain = {};
  bool open = false;
  bool (*outside)(const OperandRanges& in) = nullptr;

  /// All values inside the domain. A function of one operand that rises or falls takes those of the operand's
  /// ends; others are bounded by `range`, or by the codomain.
  Interval codomain = {};
  enum class Shape { Rises, Falls, Other } shape = Shape::Other;
  Interval (*range)(const OperandRanges& in) = nullptr;

  SmallSignal small_signal = SmallSignal::Linear;
  /// d(value) / d(operand `which`); nullptr: it steps.
  double (*slope)(const OperandValues& at, int which) = nullptr;

  bool is_function() const { return *arguments != '\0'; }
  std::string use() const { return std::string{name} + "(" + arguments + ")"; }
};

// Of the entries of `kOperators` that take more than a line.
Interval mod_range(const OperandRanges& in);
Interval mix_range(const OperandRanges& in);
Interval pow_range(const OperandRanges& in);
bool pow_is_outside(const OperandRanges& in);
double pow_slope(const OperandValues& at, int which);
double atan2_slope(const OperandValues& at, int which);

namespace operators {

using Op = Expression::Op;
using enum SmallSignal;
using enum Operator::Shape;
inline constexpr Interval kFlag{0, 1};
inline constexpr double kLog2 = 0x1.62e42fefa39efp-1, kLog10 = 0x1.26bb1bbb55516p+1;

/// Of two numbers of one unit: 1 or 0.
constexpr Operator comparison(Op op, const char* sign, double (*value)(double, double, double) noexcept) {
  return {.op = op,
          .name = sign,
          .operands = 2,
          .operand_units = "uu",
          .value = value,
          .codomain = kFlag,
          .small_signal = Event};
}

}  // namespace operators

// clang-format off
inline constexpr auto kOperators = [] {
  using namespace operators;
  return std::to_array<Operator>({
    {.op = Op::Signal, .name = "copy", .operand_units = "u", .unit = 'u',
     .value = [](double a, double, double) noexcept { return a; },
     .range = [](const OperandRanges& in) { return in[0]; },
     .slope = [](const OperandValues&, int) { return 1.0; }},
    {.op = Op::Negate, .name = "-", .operand_units = "u", .unit = 'u',
     .value = [](double a, double, double) noexcept { return -a; },
     .range = [](const OperandRanges& in) { return -in[0]; },
     .slope = [](const OperandValues&, int) { return -1.0; }},
    {.op = Op::Add, .name = "+", .operands = 2, .operand_units = "uu", .unit = 'u',
     .value = [](double a, double b, double) noexcept { return a + b; }, .can_fail = true,
     .range = [](const OperandRanges& in) { return in[0] + in[1]; },
     .slope = [](const OperandValues&, int) { return 1.0; }},
    {.op = Op::Subtract, .name = "-", .operands = 2, .operand_units = "uu", .unit = 'u',
     .value = [](double a, double b, double) noexcept { return a - b; }, .can_fail = true,
     .range = [](const OperandRanges& in) { return in[0] - in[1]; },
     .slope = [](const OperandValues&, int which) { return which == 0 ? 1.0 : -1.0; }},
    {.op = Op::Multiply, .name = "*", .operands = 2, .operand_units = "??", .unit = '*',
     .value = [](double a, double b, double) noexcept { return a * b; }, .can_fail = true,
     .range = [](const OperandRanges& in) { return in[0] * in[1]; }, .small_signal = Product,
     .slope = [](const OperandValues& at, int which) { return which == 0 ? at[1] : at[0]; }},
    // A division by zero gives zero: a control at its end must not make a loop fault.
    {.op = Op::Divide, .name = "/", .operands = 2, .operand_units = "??", .unit = '/',
     .value = [](double a, double b, double) noexcept { return b == 0 ? 0 : a / b; }, .can_fail = true,
     .range = [](const OperandRanges& in) { return divide(in[0], in[1]); }, .small_signal = Quotient,
     .slope = [](const OperandValues& at, int which) {
       return at[1] == 0 ? 0 : which == 0 ? 1 / at[1] : -at[0] / (at[1] * at[1]);
     }},

    comparison(Op::Less, "<", [](double a, double b, double) noexcept { return a < b ? 1.0 : 0.0; }),
    comparison(Op::LessOrEqual, "<=", [](double a, double b, double) noexcept { return a <= b ? 1.0 : 0.0; }),
    comparison(Op::Greater, ">", [](double a, double b, double) noexcept { return a > b ? 1.0 : 0.0; }),
    comparison(Op::GreaterOrEqual, ">=", [](double a, double b, double) noexcept { return a >= b ? 1.0 : 0.0; }),
    comparison(Op::Equal, "==", [](double a, double b, double) noexcept { return a == b ? 1.0 : 0.0; }),
    comparison(Op::NotEqual, "!=", [](double a, double b, double) noexcept { return a != b ? 1.0 : 0.0; }),

    // Minimum and maximum take `b` when `a` is not a number.
    {.op = Op::Min, .name = "min", .arguments = "a, b", .operands = 2, .operand_units = "uu", .unit = 'u',
     .value = [](double a, double b, double) noexcept { return a < b ? a : b; },
     .range = [](const OperandRanges& in) { return min(in[0], in[1]); }, .small_signal = Corner,
     .slope = [](const OperandValues& at, int which) { return (at[0] < at[1]) == (which == 0) ? 1.0 : 0.0; }},
    {.op = Op::Max, .name = "max", .arguments = "a, b", .operands = 2, .operand_units = "uu", .unit = 'u',
     .value = [](double a, double b, double) noexcept { return a > b ? a : b; },
     .range = [](const OperandRanges& in) { return max(in[0], in[1]); }, .small_signal = Corner,
     .slope = [](const OperandValues& at, int which) { return (at[0] > at[1]) == (which == 0) ? 1.0 : 0.0; }},
    {.op = Op::Abs, .name = "abs", .arguments = "x", .operand_units = "u", .unit = 'u',
     .value = [](double a, double, double) noexcept { return std::fabs(a); },
     .range = [](const OperandRanges& in) { return abs(in[0]); }, .small_signal = Corner,
     .slope = [](const OperandValues& at, int) { return at[0] < 0 ? -1.0 : at[0] > 0 ? 1.0 : 0.0; }},
    {.op = Op::Sign, .name = "sign", .arguments = "x", .operand_units = "?",
     .value = [](double a, double, double) noexcept { return (a > 0 ? 1.0 : 0.0) - (a < 0 ? 1.0 : 0.0); },
     .codomain = {-1, 1}, .shape = Rises, .small_signal = Event},
    {.op = Op::Floor, .name = "floor", .arguments = "x",
     .value = [](double a, double, double) noexcept { return math::floor(a); },
     .shape = Rises, .small_signal = Event},
    {.op = Op::Ceil, .name = "ceil", .arguments = "x",
     .value = [](double a, double, double) noexcept { return math::ceil(a); },
     .shape = Rises, .small_signal = Event},
    {.op = Op::Round, .name = "round", .arguments = "x",
     .value = [](double a, double, double) noexcept { return math::round(a); },
     .shape = Rises, .small_signal = Event},
    {.op = Op::Mod, .name = "mod", .arguments = "a, b", .operands = 2, .operand_units = "uu", .unit = 'u',
     .value = [](double a, double b, double) noexcept { return math::mod(a, b); }, .can_fail = true,
     .domain_text = "b not 0", .outside = [](const OperandRanges& in) { return in[1].low == 0 && in[1].high == 0; },
     .range = mod_range, .small_signal = Event},
    {.op = Op::Clamp, .name = "clamp", .arguments = "x, low, high", .operands = 3, .operand_units = "uuu",
     .unit = 'u', .definition = "max(b, min(c, a))",
     .range = [](const OperandRanges& in) { return max(in[1], min(in[2], in[0])); }},
    {.op = Op::Mix, .name = "mix", .arguments = "a, b, t", .operands = 3, .operand_units = "uu1", .unit = 'u',
     .definition = "a + (b - a) * c", .range = mix_range},
    {.op = Op::Select, .name = "select", .arguments = "condition, a, b", .operands = 3, .operand_units = "1uu",
     .unit = 'u', .value = [](double a, double b, double c) noexcept { return a != 0 ? b : c; },
     .range = [](const OperandRanges& in) { return in[1].joined(in[2]); }, .small_signal = Choice,
     .slope = [](const OperandValues& at, int which) { return which > 0 && (at[0] != 0) == (which == 1) ? 1.0 : 0.0; }},

    {.op = Op::Sqrt, .name = "sqrt", .arguments = "x", .operand_units = "?", .unit = 'r',
     .value = [](double a, double, double) noexcept { return std::sqrt(a); }, .can_fail = true,
     .domain_text = "x at least 0", .domain = {0, kUnlimited}, .codomain = {0, kUnlimited}, .shape = Rises,
     .small_signal = Curved, .slope = [](const OperandValues& at, int) { return 0.5 / std::sqrt(at[0]); }},
    {.op = Op::Pow, .name = "pow", .arguments = "a, b", .operands = 2, .operand_units = "?1", .unit = 'p',
     .value = [](double a, double b, double) noexcept { return math::pow(a, b); }, .can_fail = true,
     .domain_text = "a > 0, a = 0 with b at least 0, or a whole b", .outside = pow_is_outside,
     .range = pow_range, .small_signal = Curved, .slope = pow_slope},
    {.op = Op::Exp, .name = "exp", .arguments = "x",
     .value = [](double a, double, double) noexcept { return math::exp(a); }, .can_fail = true,
     .codomain = {0, kUnlimited}, .shape = Rises, .small_signal = Curved,
     .slope = [](const OperandValues& at, int) { return math::exp(at[0]); }},
    {.op = Op::Log, .name = "log", .arguments = "x",
     .value = [](double a, double, double) noexcept { return math::log(a); }, .can_fail = true,
     .domain_text = "x > 0", .domain = {0, kUnlimited}, .open = true, .shape = Rises,
     .small_signal = Curved, .slope = [](const OperandValues& at, int) { return 1 / at[0]; }},
    {.op = Op::Log2, .name = "log2", .arguments = "x",
     .value = [](double a, double, double) noexcept { return math::log2(a); }, .can_fail = true,
     .domain_text = "x > 0", .domain = {0, kUnlimited}, .open = true, .shape = Rises,
     .small_signal = Curved, .slope = [](const OperandValues& at, int) { return 1 / (kLog2 * at[0]); }},
    {.op = Op::Log10, .name = "log10", .arguments = "x",
     .value = [](double a, double, double) noexcept { return math::log10(a); }, .can_fail = true,
     .domain_text = "x > 0", .domain = {0, kUnlimited}, .open = true, .shape = Rises,
     .small_signal = Curved, .slope = [](const OperandValues& at, int) { return 1 / (kLog10 * at[0]); }},

    {.op = Op::Sin, .name = "sin", .arguments = "x",
     .value = [](double a, double, double) noexcept { return math::sin(a); },
     .codomain = {-1, 1}, .small_signal = Bounded,
     .slope = [](const OperandValues& at, int) { return math::cos(at[0]); }},
    {.op = Op::Cos, .name = "cos", .arguments = "x",
     .value = [](double a, double, double) noexcept { return math::cos(a); },
     .codomain = {-1, 1}, .small_signal = Bounded,
     .slope = [](const OperandValues& at, int) { return -math::sin(at[0]); }},
    {.op = Op::Tan, .name = "tan", .arguments = "x",
     .value = [](double a, double, double) noexcept { return math::tan(a); },
     .small_signal = Curved,
     .slope = [](const OperandValues& at, int) { return 1 + math::tan(at[0]) * math::tan(at[0]); }},
    {.op = Op::Asin, .name = "asin", .arguments = "x",
     .value = [](double a, double, double) noexcept { return math::asin(a); }, .can_fail = true,
     .domain_text = "x from -1 to 1", .domain = {-1, 1}, .codomain = {-kPi / 2, kPi / 2}, .shape = Rises,
     .small_signal = Curved, .slope = [](const OperandValues& at, int) { return 1 / std::sqrt(1 - at[0] * at[0]); }},
    {.op = Op::Acos, .name = "acos", .arguments = "x",
     .value = [](double a, double, double) noexcept { return math::acos(a); }, .can_fail = true,
     .domain_text = "x from -1 to 1", .domain = {-1, 1}, .codomain = {0, kPi}, .shape = Falls,
     .small_signal = Curved, .slope = [](const OperandValues& at, int) { return -1 / std::sqrt(1 - at[0] * at[0]); }},
    {.op = Op::Atan, .name = "atan", .arguments = "x",
     .value = [](double a, double, double) noexcept { return math::atan(a); },
     .codomain = {-kPi / 2, kPi / 2}, .shape = Rises, .small_signal = Bounded,
     .slope = [](const OperandValues& at, int) { return 1 / (1 + at[0] * at[0]); }},
    {.op = Op::Atan2, .name = "atan2", .arguments = "y, x", .operands = 2, .operand_units = "uu",
     .value = [](double a, double b, double) noexcept { return math::atan2(a, b); },
     .codomain = {-kPi, kPi}, .small_signal = Curved, .slope = atan2_slope},
    {.op = Op::Tanh, .name = "tanh", .arguments = "x",
     .value = [](double a, double, double) noexcept { return math::tanh(a); },
     .codomain = {-1, 1}, .shape = Rises, .small_signal = Bounded,
     .slope = [](const OperandValues& at, int) { return 1 - math::tanh(at[0]) * math::tanh(at[0]); }},
  });
}();
// clang-format on

/// [any] Whether expressions of this kind compute something: numbers and lists do not, a name copies.
constexpr bool is_operator(Expression::Op op) { return op >= Expression::Op::Signal; }
constexpr std::size_t entry_of(Expression::Op op) {
  return static_cast<std::size_t>(op) - static_cast<std::size_t>(Expression::Op::Signal);
}
/// [any] Of `is_operator(op)`.
constexpr const Operator& operator_of(Expression::Op op) { return kOperators[entry_of(op)]; }

/// The function of that name, or nullptr.
const Operator* find_function(std::string_view name);
/// Their names, in the order of the table.
const std::vector<std::string>& function_names();
/// `pi` and `e`; nullptr: no constant of that name.
const double* find_constant(std::string_view name);
/// Names that nothing in a file can have, since expressions give them a meaning: "system", "pi", "min".
std::span<const std::string_view> reserved_names();

/// Whether no operands in these ranges are inside the domain.
bool is_outside(const Operator& type, const OperandRanges& in);
/// All values that it can take, 0 included where it can fault.
Interval range_of(const Operator& type, const OperandRanges& in);
/// What replaces an operator without a `value`, its operands named a, b and c; nullptr: nothing does.
const Expression* definition_of(Expression::Op op);

/// [any] One operator on numbers; operands that it does not have are not read.
inline double evaluate(Expression::Op op, double a, double b, double c) noexcept {
  return operator_of(op).value(a, b, c);
}

}  // namespace tactus
