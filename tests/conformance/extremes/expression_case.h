#pragma once

#include <array>
#include <string>
#include <vector>

#include "engine/graph/semantics/operators.h"
#include "tests/conformance/extremes/extreme_case.h"

namespace tactus::test {

/// An operator or function of an expression with its operands, each a number in the file or a signal.
struct ExpressionCase {
  Expression::Op op{};
  OperandValues at{};
  std::array<bool, kMostOperands> moves{};

  std::string name() const;
};

/// Every operator with every pair of numbers; those of three operands with fewer.
std::vector<ExpressionCase> expression_cases();
/// [control] Beside the same operator in long double; a division by 0 gives 0, and what lies outside a domain
/// faults.
Judgement judge(const ExpressionCase& one);

}  // namespace tactus::test
