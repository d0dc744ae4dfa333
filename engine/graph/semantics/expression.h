#pragma once

// Thread: [any]

#include <string>
#include <string_view>
#include <vector>

#include "engine/core/dimension.h"
#include "engine/core/error.h"
#include "engine/graph/file/value.h"

namespace tactus {

/// What a signal port is set to. `parse_expression` leaves the names for `bind_signal` to look up.
///
///   expression = sum [ ("<" | "<=" | ">" | ">=" | "==" | "!=") sum ]
///   sum        = product { ("+" | "-") product }
///   product    = factor { ("*" | "/") factor }
///   factor     = "-" factor | number [unit] | "pi" | "e" | name [lanes] | "(" expression ")"
///              | function "(" expression { "," expression } ")"
///   lanes      = "[" lane [".." lane] { "," lane [".." lane] } "]"
///
/// The functions are those of the table in operators.h.
/// A unit directly follows its number ("15 ms", "2 N/m"); there it wins over a name of the same
/// letters. Its factors are joined by spaces ("N s/m") or a '/' without spaces: in "2 N / s" and "2 N * s"
/// the s is a name. A sign belongs to the number behind it, so "-34 dB" is a small gain. Names have dots:
/// "filter.low", "drum.stick.position", "system.rate".
///
/// A signal port may also hold a list of one expression for each lane, or a spread over the lanes.
struct Expression {
  /// From Signal on in the order of the table in operators.h.
  enum class Op {
    Number,
    Lanes,
    Spread,
    Pick,
    Signal,
    Negate,
    Add,
    Subtract,
    Multiply,
    Divide,
    Less,
    LessOrEqual,
    Greater,
    GreaterOrEqual,
    Equal,
    NotEqual,
    Min,
    Max,
    Abs,
    Sign,
    Floor,
    Ceil,
    Round,
    Mod,
    Clamp,
    Mix,
    Select,
    Sqrt,
    Pow,
    Exp,
    Log,
    Log2,
    Log10,
    Sin,
    Cos,
    Tan,
    Asin,
    Acos,
    Atan,
    Atan2,
    Tanh
  };

  Op op = Op::Number;
  double number = 0;         ///< SI
  Dimension dimension = {};  ///< of a number with a unit
  bool bare = false;         ///< a number without a unit: takes the dimension that its place asks for
  bool exponential = false;  ///< Spread: along a geometric curve
  std::string name = {};     ///< Signal, as written
  int signal = -1;           ///< Signal, once its name is looked up
  std::vector<int> lanes =
      {};  ///< Pick: those of its argument, from 0, in the order in which they are wanted
  std::vector<Expression> arguments = {};
  Source at = {};  ///< of this part of the text; of an operator, its sign
};

/// `at` is the place of the first character of `text` in the file. Errors: Syntax, with the column of what
/// could not be read and what was expected there.
Result<Expression> parse_expression(std::string_view text, const Source& at);

/// Whether expressions give the name a meaning of their own: "system", "pi", "min". Nothing in a file can
/// have it.
bool is_reserved(std::string_view name);

/// [a-z][a-z0-9_]*
bool is_name(std::string_view word);

/// The place of the first letter of a string: behind its quote.
Source text_start(const Value& value);

}  // namespace tactus
