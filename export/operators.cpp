#include "export/operators.h"

#include <algorithm>
#include <array>

#include "engine/graph/semantics/operators.h"

namespace tactus {
namespace {

using Op = Expression::Op;
using enum CExpression::Binding;

/// What an operator of expressions is in C.
struct Written {
  Op op;
  enum class Form { Prefix, Infix, Flag, Call, Choice } form = Form::Call;
  const char* exact;            ///< sign, or function with the bits of the engine
  const char* of_library = "";  ///< function of math.h for numbers without these; "": `exact`
  CExpression::Binding binding = Operand;
  bool domain = false;
};

using enum Written::Form;
constexpr auto kWritten = std::to_array<Written>({
    {Op::Signal, Prefix, "", "", Operand},
    {Op::Negate, Prefix, "-", "", Sign},
    {Op::Add, Infix, "+", "", Sum},
    {Op::Subtract, Infix, "-", "", Sum},
    {Op::Multiply, Infix, "*", "", Product},
    {Op::Divide, Call, "tactus_quotient"},
    {Op::Less, Flag, "<"},
    {Op::LessOrEqual, Flag, "<="},
    {Op::Greater, Flag, ">"},
    {Op::GreaterOrEqual, Flag, ">="},
    {Op::Equal, Flag, "=="},
    {Op::NotEqual, Flag, "!="},
    {Op::Min, Call, "tactus_smaller"},
    {Op::Max, Call, "tactus_larger"},
    {Op::Abs, Call, "fabs"},
    {Op::Sign, Call, "tactus_sign"},
    {Op::Floor, Call, "floor"},
    {Op::Ceil, Call, "ceil"},
    {Op::Round, Call, "tactus_round"},
    {Op::Mod, Call, "tactus_mod", "tactus_modulo", Operand, true},
    {Op::Select, Choice, ""},
    {Op::Sqrt, Call, "sqrt", "", Operand, true},
    {Op::Pow, Call, "tactus_pow", "pow", Operand, true},
    {Op::Exp, Call, "tactus_exp", "exp", Operand, true},
    {Op::Log, Call, "tactus_log", "log", Operand, true},
    {Op::Log2, Call, "tactus_log2", "log2", Operand, true},
    {Op::Log10, Call, "tactus_log10", "log10", Operand, true},
    {Op::Sin, Call, "tactus_sin", "sin"},
    {Op::Cos, Call, "tactus_cos", "cos"},
    {Op::Tan, Call, "tactus_tan", "tan"},
    {Op::Asin, Call, "tactus_asin", "asin", Operand, true},
    {Op::Acos, Call, "tactus_acos", "acos", Operand, true},
    {Op::Atan, Call, "tactus_atan", "atan"},
    {Op::Atan2, Call, "tactus_atan2", "atan2"},
    {Op::Tanh, Call, "tactus_tanh", "tanh"},
});

const Written& written(Op op) { return *std::ranges::find(kWritten, op, &Written::op); }

// Every operator that is executed has an entry.
static_assert(std::ranges::all_of(kOperators, [](const Operator& type) {
  return type.value == nullptr || std::ranges::find(kWritten, type.op, &Written::op) != kWritten.end();
}));

}  // namespace

CExpression c_quotient(const CExpression& a, const CExpression& b) {
  return {a.within(Product) + " / " + b.within(Sign), Product};
}

bool has_domain(Op op) { return written(op).domain; }

CExpression c_operation(Op op, std::span<const CExpression> operands, const NumberType& number) {
  const auto& how = written(op);
  const std::string sign = how.exact;
  switch (how.form) {
    case Prefix:
      return sign.empty() ? operands[0] : CExpression{sign + operands[0].within(Operand), Sign};
    case Infix: {
      // Sums of three have an order, which decides the last bits.
      const auto tighter = static_cast<CExpression::Binding>(how.binding + 1);
      return {operands[0].within(how.binding) + " " + sign + " " + operands[1].within(tighter), how.binding};
    }
    case Flag:
      return {"(tactus_real)(" + operands[0].within(Sum) + " " + sign + " " + operands[1].within(Sum) + ")",
              Sign};
    case Choice:
      return {"(" + operands[0].within(Sum) + " != 0 ? " + operands[1].within(Sum) + " : " +
              operands[2].within(Sum) + ")"};
    default:
      break;
  }
  const bool exact = number.exact_functions || how.of_library[0] == '\0';
  std::string text = exact ? how.exact : how.of_library;
  for (std::size_t i = 0; i < operands.size(); ++i) text += (i == 0 ? "(" : ", ") + operands[i].text;
  return {text + ")"};
}

}  // namespace tactus
