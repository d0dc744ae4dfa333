#include "engine/graph/file/mistakes.h"
#include "engine/graph/file/quantity.h"
#include "engine/graph/semantics/scope.h"

namespace tactus {
namespace {

void look_up_names(Expression& expression, const Scope& scope, Mistakes& mistakes) {
  if (expression.op == Expression::Op::Signal) {
    const auto signal = scope.find(expression.name, expression.at);
    if (!signal) mistakes.add(signal.error());
    expression.signal = signal.value_or(FlatGraph::kMissing);
  }
  for (auto& argument : expression.arguments) look_up_names(argument, scope, mistakes);
}

Expression number_expression(double si, Dimension dimension, bool bare, const Source& at) {
  return {.number = si, .dimension = dimension, .bare = bare, .name = {}, .arguments = {}, .at = at};
}

Expression bind_spread(const Value& value, Mistakes& mistakes) {
  Expression expression;
  expression.op = Expression::Op::Spread;
  expression.at = value.at;
  for (const auto& field : *value.table()) {
    if (field.key == "from" || field.key == "to") continue;
    if (field.key == "curve" && field.value.text() != nullptr &&
        (*field.value.text() == "linear" || *field.value.text() == "exponential")) {
      expression.exponential = *field.value.text() == "exponential";
      continue;
    }
    mistakes.add(Error{Errc::UnknownName, field.at.text(),
                       "a spread over lanes has no '" + field.key + "' like this",
                       "write { from = …, to = …, curve = \"linear\" or \"exponential\" }"});
    return missing_signal(value.at);
  }
  for (const auto* key : {"from", "to"}) {
    const auto* end = find(*value.table(), key);
    if (end == nullptr) {
      mistakes.add(Error{Errc::Missing, value.at.text(),
                         std::string{"a spread over lanes lacks '"} + key + "'",
                         "write { from = …, to = …, curve = \"linear\" or \"exponential\" }"});
      return missing_signal(value.at);
    }
    const auto quantity = read_quantity(*end);
    if (!quantity) {
      mistakes.add(quantity.error());
      return missing_signal(value.at);
    }
    expression.arguments.push_back(
        number_expression(quantity->si, quantity->unit.dimension, quantity->bare, end->at));
  }
  if (expression.exponential && !(expression.arguments[0].number * expression.arguments[1].number > 0)) {
    mistakes.add(Errc::OutOfRange, value.at, "an exponential spread cannot begin, end or pass at 0",
                 "give both ends the same sign, or take the linear curve");
    return missing_signal(value.at);
  }
  return expression;
}

}  // namespace

Expression missing_signal(const Source& at) {
  Expression expression;
  expression.op = Expression::Op::Signal;
  expression.signal = FlatGraph::kMissing;
  expression.at = at;
  return expression;
}

Expression bind_signal(const Value& value, const Scope& scope, Mistakes& mistakes) {
  if (const auto* number = value.number()) return number_expression(*number, {}, true, value.at);
  if (const auto* text = value.text()) {
    auto expression = parse_expression(*text, text_start(value));
    if (mistakes.keep(expression) == nullptr) return missing_signal(value.at);
    look_up_names(*expression, scope, mistakes);
    return std::move(*expression);
  }
  if (const auto* list = value.list()) {
    Expression expression;
    expression.op = Expression::Op::Lanes;
    expression.at = value.at;
    for (const auto& lane : *list) {
      if (lane.list() != nullptr || lane.table() != nullptr) {
        mistakes.add(Error{Errc::WrongType, lane.at.text(), "a lane cannot be " + lane.kind(),
                           "a list holds one number, quantity or expression for each lane"});
        return missing_signal(value.at);
      }
      expression.arguments.push_back(bind_signal(lane, scope, mistakes));
    }
    if (!expression.arguments.empty()) return expression;
  }
  if (value.table() != nullptr) return bind_spread(value, mistakes);
  mistakes.add(Error{Errc::WrongType, value.at.text(),
                     "a signal cannot be " + (value.list() ? "an empty list" : value.kind()),
                     "give a number, a quantity such as \"15 ms\", or an expression such as \"0.5 * x\""});
  return missing_signal(value.at);
}

}  // namespace tactus
