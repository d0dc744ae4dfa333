#pragma once

// Thread: [control].

#include <functional>
#include <span>
#include <string>

#include "engine/graph/semantics/expression.h"
#include "export/fixed/arithmetic.h"

namespace tactus {

/// A function of one operand as a table; `table` gives the name of an array with the numbers.
using MakeTable = std::function<std::string(const std::vector<std::string>& numbers)>;
FixedValue tabulated(const FixedArithmetic& arithmetic, const std::function<double(double)>& function,
                     const FixedValue& x, const MakeTable& table);

/// What an operator of expressions is in integers. `wide`: whether what reads the result takes a wide one.
struct FixedOperator {
  Expression::Op op;
  FixedValue (*write)(FixedArithmetic& arithmetic, std::span<const FixedValue> in, bool wide);
};

/// [any] The entry, or nullptr: functions of one operand are tables, others have no form in integers.
const FixedOperator* find_fixed_operator(Expression::Op op);

}  // namespace tactus
