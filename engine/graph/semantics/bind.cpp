#include "engine/graph/file/error_list.h"
#include "engine/graph/file/field.h"
#include "engine/graph/semantics/scope.h"

namespace tactus {
namespace {

void look_up_names(Expression& expression, const Scope& scope, ErrorList& errors) {
  if (expression.op == Expression::Op::Signal) {
    const auto signal = scope.find(expression.name, expression.at);
    if (!signal) errors.add(signal.error());
    expression.signal = signal.value_or(FlatGraph::kMissing);
  }
  for (auto& argument : expression.arguments) look_up_names(argument, scope, errors);
}

Expression make(Expression::Op op, const Source& at) {
  Expression expression;
  expression.op = op;
  expression.at = at;
  return expression;
}

Expression missing_with_error(ErrorList& errors, Errc code, const Source& at, const std::string& what,
                              const std::string& remedy) {
  errors.add(code, at, what, remedy);
  return missing_signal(at);
}

const SectionType& spread_fields() {
  static const SectionType section{
      "a spread over lanes",
      {required(field("from", FieldType::Kind::Any, "of the first lane")),
       required(field("to", FieldType::Kind::Any, "of the last lane")),
       choice_field("curve", {"linear", "exponential"}, "from one end to the other", "linear")}};
  return section;
}

Expression bind_spread(const Value& value, ErrorList& errors) {
  FieldReader fields{*value.table(), spread_fields(), errors, "a spread over lanes"};
  auto expression = make(Expression::Op::Spread, value.at);
  expression.exponential = fields.choice("curve") == 1;
  for (const auto* key : {"from", "to"}) {
    if (!fields.has(key))
      return missing_with_error(errors, Errc::Missing, value.at,
                                std::string{"a spread over lanes lacks '"} + key + "'",
                                "write { from = …, to = …, curve = \"linear\" or \"exponential\" }");
    const auto quantity = fields.any(key);
    if (!quantity) return missing_signal(value.at);
    expression.arguments.push_back(
        number_expression(quantity->si, quantity->unit.dimension, quantity->bare, fields.value(key)->at));
  }
  if (expression.exponential && !(expression.arguments[0].number * expression.arguments[1].number > 0))
    return missing_with_error(errors, Errc::OutOfRange, value.at,
                              "an exponential spread cannot begin, end or pass at 0",
                              "give both ends the same sign, or take the linear curve");
  return expression;
}

}  // namespace

Expression number_expression(double si, Dimension dimension, bool bare, const Source& at) {
  return {.number = si, .dimension = dimension, .bare = bare, .name = {}, .arguments = {}, .at = at};
}

Expression missing_signal(const Source& at) {
  auto expression = make(Expression::Op::Signal, at);
  expression.signal = FlatGraph::kMissing;
  return expression;
}

Expression bind_signal(const Value& value, const Scope& scope, ErrorList& errors) {
  if (const auto* number = value.number()) return number_expression(*number, {}, true, value.at);
  if (const auto* text = value.text()) {
    auto expression = parse_expression(*text, text_start(value));
    if (errors.keep(expression) == nullptr) return missing_signal(value.at);
    look_up_names(*expression, scope, errors);
    return std::move(*expression);
  }
  if (const auto* list = value.list()) {
    auto expression = make(Expression::Op::Lanes, value.at);
    for (const auto& lane : *list) {
      if (lane.list() != nullptr || lane.table() != nullptr)
        return missing_with_error(errors, Errc::WrongType, lane.at, "a lane cannot be " + lane.kind(),
                                  "a list holds one number, quantity or expression for each lane");
      expression.arguments.push_back(bind_signal(lane, scope, errors));
    }
    if (!expression.arguments.empty()) return expression;
  }
  if (value.table() != nullptr) return bind_spread(value, errors);
  return missing_with_error(
      errors, Errc::WrongType, value.at,
      "a signal cannot be " + (value.list() ? "an empty list" : value.kind()),
      "give a number, a quantity such as \"15 ms\", or an expression such as \"0.5 * x\"");
}

}  // namespace tactus
