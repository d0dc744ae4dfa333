#include "engine/graph/file/field.h"
#include "engine/graph/file/load.h"
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

Expression missing_with_error(ErrorList& errors, Errc code, const Source& at, const std::string& what,
                              const std::string& remedy) {
  errors.add(code, at, what, remedy);
  return missing_signal(at);
}

const SectionType& spread_fields() {
  static const SectionType section{
      "a spread over lanes",
      {required(field("from", FieldType::Kind::Any, "value of the first lane")),
       required(field("to", FieldType::Kind::Any, "value of the last lane")),
       choice_field("curve", {"linear", "exponential"}, "spacing of the values", "linear")}};
  return section;
}

Expression bind_spread(const Value& value, ErrorList& errors) {
  FieldReader fields{*value.table(), spread_fields(), errors, "a spread over lanes"};
  Expression expression{
      .op = Expression::Op::Spread, .exponential = fields.choice("curve") == 1, .at = value.at};
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
                              "an exponential spread cannot start at, end at or cross 0",
                              "give both ends the same sign, or use the linear curve");
  return expression;
}

/// Reads a list that one setting of one node is; its errors have the place and the name of the node.
struct ListReader {
  const Setting& setting;
  const Value::Table& fields;
  const std::string& owner;  ///< "delay 'echo'"
  ErrorList& errors;
  SettingValue& result;

  void read(const Value& value) {
    const auto* list = value.list();
    if (list == nullptr || list->empty())
      return report(value.at, "must be a non-empty list", "as in " + setting.doc);
    for (const auto& item : *list) {
      if (setting.kind == Setting::Kind::Names)
        read_name(item);
      else if (setting.kind == Setting::Kind::Points)
        read_point(item);
      else if (const auto number = quantity(item, 0))
        result.numbers.push_back(*number);
    }
  }

  void report(const Source& at, const std::string& what, const std::string& remedy) {
    errors.add(Errc::WrongType, at, key_of(setting.name, owner) + " " + what, remedy);
  }

  /// Of one axis: fixed, that of another setting ("=unit"), or that of a port, which is not known here.
  std::optional<Unit> unit(std::size_t axis) const {
    const std::string text = axis < setting.choices.size() ? setting.choices[axis] : "";
    if (!text.starts_with('=')) return turned(parse_unit(text));
    const auto* named = find(fields, text.substr(1));
    if (named == nullptr) return text == "=unit" ? std::optional{Unit{}} : std::nullopt;
    return text == "=unit" && named->text() != nullptr ? parse_unit(*named->text()) : std::nullopt;
  }

  /// In a node that turns: kMotionSetting.
  std::optional<Unit> turned(std::optional<Unit> unit) const {
    const auto* motion = find(fields, kMotionSetting);
    if (unit && motion != nullptr && motion->text() != nullptr && *motion->text() == kRotation)
      return Unit{in_rotation(unit->dimension)};
    return unit;
  }

  std::optional<double> quantity(const Value& value, std::size_t axis) {
    const auto expected = unit(axis);
    const auto si = expected ? read_quantity(value, *expected, setting.name)
                             : read_quantity(value).map([](const QuantityValue& q) { return q.si; });
    return errors.keep(si) != nullptr ? std::optional{*si} : std::nullopt;
  }

  void read_name(const Value& item) {
    if (item.text() != nullptr) return result.names.push_back(*item.text());
    report(item.at, "must be a list of node names", "write [\"node\", \"node\"]");
  }

  void read_point(const Value& item) {
    const auto* pair = item.list();
    if (pair == nullptr || pair->size() != 2)
      return report(item.at, "must hold pairs", "write [[x, y], [x, y], …]");
    const auto x = quantity((*pair)[0], 0);
    const auto y = quantity((*pair)[1], 1);
    if (x && y) result.points.emplace_back(*x, *y);
  }
};

}  // namespace

Expression number_expression(double si, Dimension dimension, bool bare, const Source& at) {
  return {.number = si, .dimension = dimension, .bare = bare, .at = at};
}

Expression missing_signal(const Source& at) {
  return {.op = Expression::Op::Signal, .signal = FlatGraph::kMissing, .at = at};
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
    Expression expression{.op = Expression::Op::Lanes, .at = value.at};
    for (const auto& lane : *list) {
      if (lane.list() != nullptr || lane.table() != nullptr)
        return missing_with_error(errors, Errc::WrongType, lane.at, "a lane cannot be " + lane.kind(),
                                  "a list must have one number, quantity or expression for each lane");
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

/// What a setting is where it is left out, in SI.
static double fallback_number(const Setting& setting) {
  if (setting.fallback.empty()) return 0.0;
  const auto unit = parse_unit(setting.unit()).value_or(Unit{});
  return read_quantity({setting.fallback, {}}, unit, setting.name).value();
}

SettingValue bind_setting(const Setting& setting, const Value::Table& fields,
                          const std::filesystem::path& folder, const std::string& owner, const Source& at,
                          ErrorList& errors) {
  using Kind = Setting::Kind;
  FieldReader reader{fields, {&setting, 1}, errors, FieldReader::kKeysChecked, owner};
  const auto* value = reader.value(setting.name);
  SettingValue result;
  result.given = value != nullptr;
  if (value == nullptr) {
    if (setting.required)
      errors.add(Errc::Missing, at, owner + " lacks '" + setting.name + "'",
                 "write " + setting.name + " = … (" + setting.doc + ")");
    result.text = setting.fallback;
    if (setting.kind == Kind::Integer || setting.kind == Kind::Quantity)
      result.number = fallback_number(setting);
  } else if (setting.kind == Kind::Choice) {
    if (const auto choice = reader.choice(setting.name)) result.text = setting.choices[index(*choice)];
  } else if (setting.kind == Kind::Integer || setting.kind == Kind::Quantity) {
    result.number = reader.number(setting.name).value_or(0);
  } else if (setting.kind == Kind::Unit) {
    if (reader.unit(setting.name)) result.text = *value->text();
  } else if (setting.kind == Kind::Text || setting.kind == Kind::File) {
    result.text = reader.text(setting.name);
    if (setting.kind == Kind::File && value->text() != nullptr) {
      const auto found = find_part(result.text, folder, folder, value->at);
      if (errors.keep(found) != nullptr) result.text = found->name;
    }
  } else {
    ListReader{setting, fields, owner, errors, result}.read(*value);
  }
  return result;
}

}  // namespace tactus
