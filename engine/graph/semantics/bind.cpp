#include "engine/graph/semantics/bind.h"

#include <cmath>

#include "engine/graph/file/nearest.h"
#include "engine/graph/file/quantity.h"

namespace tactus {
namespace {

Term::Op term_op(Expression::Op op) {
  switch (op) {
    case Expression::Op::Negate:
      return Term::Op::Negate;
    case Expression::Op::Add:
      return Term::Op::Add;
    case Expression::Op::Subtract:
      return Term::Op::Subtract;
    case Expression::Op::Multiply:
      return Term::Op::Multiply;
    case Expression::Op::Divide:
      return Term::Op::Divide;
    case Expression::Op::Min:
      return Term::Op::Min;
    case Expression::Op::Max:
      return Term::Op::Max;
    case Expression::Op::Abs:
      return Term::Op::Abs;
    case Expression::Op::Name:
      return Term::Op::Signal;
    case Expression::Op::Number:
      break;
  }
  return Term::Op::Number;
}

Term look_up(const Expression& expression, const Scope& scope, Mistakes& mistakes) {
  Term term{.op = term_op(expression.op),
            .number = expression.number,
            .dimension = expression.dimension,
            .bare = expression.bare,
            .signal = -1,
            .arguments = {},
            .at = expression.at};
  if (expression.op == Expression::Op::Name) {
    if (const auto signal = scope.find(expression.name, expression.at)) {
      term.signal = *signal;
    } else {
      mistakes.add(signal.error());
      term.signal = FlatGraph::kMissing;
    }
  }
  for (const auto& argument : expression.arguments)
    term.arguments.push_back(look_up(argument, scope, mistakes));
  return term;
}

Term number_term(double si, Dimension dimension, bool bare, const Source& at) {
  Term term;
  term.number = si;
  term.dimension = dimension;
  term.bare = bare;
  term.at = at;
  return term;
}

Term bind_spread(const Value& value, Mistakes& mistakes) {
  Term term;
  term.op = Term::Op::Spread;
  term.at = value.at;
  for (const auto& field : *value.table()) {
    if (field.key == "from" || field.key == "to") continue;
    if (field.key == "curve" && field.value.text() != nullptr &&
        (*field.value.text() == "linear" || *field.value.text() == "exponential")) {
      term.bare = *field.value.text() == "linear";
      continue;
    }
    mistakes.add(Error{Errc::UnknownName, field.at.text(),
                       "a spread over lanes has no '" + field.key + "' like this",
                       "write { from = …, to = …, curve = \"linear\" or \"exponential\" }"});
    return missing_term(value.at);
  }
  for (const auto* key : {"from", "to"}) {
    const auto* end = find(*value.table(), key);
    if (end == nullptr) {
      mistakes.add(Error{Errc::Missing, value.at.text(),
                         std::string{"a spread over lanes lacks '"} + key + "'",
                         "write { from = …, to = …, curve = \"linear\" or \"exponential\" }"});
      return missing_term(value.at);
    }
    const auto quantity = read_quantity(*end);
    if (!quantity) {
      mistakes.add(quantity.error());
      return missing_term(value.at);
    }
    term.arguments.push_back(number_term(quantity->si, quantity->unit.dimension, quantity->bare, end->at));
  }
  if (!term.bare && !(term.arguments[0].number * term.arguments[1].number > 0)) {
    mistakes.add(Errc::OutOfRange, value.at, "an exponential spread cannot begin, end or pass at 0",
                 "give both ends the same sign, or take the linear curve");
    return missing_term(value.at);
  }
  return term;
}

}  // namespace

Term missing_term(const Source& at) {
  Term term;
  term.op = Term::Op::Signal;
  term.signal = FlatGraph::kMissing;
  term.at = at;
  return term;
}

Term bind_signal(const Value& value, const Scope& scope, Mistakes& mistakes) {
  if (const auto* number = value.number()) return number_term(*number, {}, true, value.at);
  if (const auto* text = value.text()) {
    const auto expression = parse_expression(*text, text_start(value));
    const auto* parsed = mistakes.keep(expression);
    return parsed != nullptr ? look_up(*parsed, scope, mistakes) : missing_term(value.at);
  }
  if (const auto* list = value.list()) {
    Term term;
    term.op = Term::Op::Lanes;
    term.at = value.at;
    for (const auto& lane : *list) {
      if (lane.list() != nullptr || lane.table() != nullptr) {
        mistakes.add(Error{Errc::WrongType, lane.at.text(), "a lane cannot be " + lane.kind(),
                           "a list holds one number, quantity or expression for each lane"});
        return missing_term(value.at);
      }
      term.arguments.push_back(bind_signal(lane, scope, mistakes));
    }
    if (!term.arguments.empty()) return term;
  }
  if (value.table() != nullptr) return bind_spread(value, mistakes);
  mistakes.add(Error{Errc::WrongType, value.at.text(),
                     "a signal cannot be " + (value.list() ? "an empty list" : value.kind()),
                     "give a number, a quantity such as \"15 ms\", or an expression such as \"0.5 * x\""});
  return missing_term(value.at);
}

}  // namespace tactus
