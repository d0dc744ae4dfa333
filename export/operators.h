#pragma once

// Thread: [control].

#include <span>
#include <string>

#include "engine/graph/semantics/expression.h"
#include "export/number.h"

namespace tactus {

/// C text, and how tightly its last operator binds: a higher one needs no brackets inside a lower one.
struct CExpression {
  enum Binding { Comparison, Sum, Product, Sign, Operand };
  std::string text;
  Binding binding = Operand;

  /// In brackets unless it binds at least so tightly.
  std::string within(Binding least) const { return binding >= least ? text : "(" + text + ")"; }
};

/// An operator of expressions applied to its operands; not finite outside its domain.
CExpression c_operation(Expression::Op op, std::span<const CExpression> operands, const NumberType& number);
/// a / b where b is not 0.
CExpression c_quotient(const CExpression& a, const CExpression& b);
/// Whether the result must be made finite: an operator with a domain. Sums and products that overflow count
/// as faults of the program.
bool has_domain(Expression::Op op);

}  // namespace tactus
