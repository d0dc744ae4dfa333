#pragma once

#include <string>
#include <vector>

#include "engine/graph/semantics/expression.h"
#include "tests/conformance/extremes/extreme_case.h"

namespace tactus::test {

/// An operator of an expression with two numbers, each in the file or as a signal.
struct ExpressionCase {
  Expression::Op op{};
  double a = 0, b = 0;
  bool a_moves = false, b_moves = false;

  std::string name() const;
};

/// Every operator with every pair of numbers.
std::vector<ExpressionCase> expression_cases();
/// [control] Beside the same operator in long double; a division by 0 gives 0.
Judgement judge(const ExpressionCase& one);

}  // namespace tactus::test
