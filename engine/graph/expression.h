#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "engine/core/dimension.h"
#include "engine/core/error.h"
#include "engine/graph/source.h"

namespace tactus {

/// A parsed expression: what a string in a signal port means. Names are not looked up yet.
///
///   sum     = product { ("+" | "-") product }
///   product = factor { ("*" | "/") factor }
///   factor  = "-" factor | number [unit] | name | ("min" | "max") "(" sum "," sum ")" | "abs" "(" sum ")"
///           | "(" sum ")"
///
/// A unit stands directly behind its number ("15 ms", "2 N/m"); there it wins over a name of the same letters.
/// Names have dots: "filter.low", "drum.stick.position", "system.rate".
struct Expression {
  enum class Op { Number, Name, Negate, Add, Subtract, Multiply, Divide, Min, Max, Abs };

  Op op = Op::Number;
  double number = 0;     ///< SI
  Dimension dimension;   ///< of a number with a unit
  bool bare = false;     ///< a number without a unit: takes the dimension that its place asks for
  std::string name;
  std::vector<Expression> arguments;
  Source at;  ///< of this part of the text
};

/// `at` is where the first character of `text` stands in the file. Errors: Syntax, with the column of what could
/// not be read and what was expected there.
Result<Expression> parse_expression(std::string_view text, const Source& at);

}  // namespace tactus
