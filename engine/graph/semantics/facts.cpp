#include "engine/graph/semantics/facts.h"

#include <algorithm>
#include <cmath>

#include "engine/graph/semantics/operators.h"

namespace tactus {
namespace {

const FlatSignal& signal_of(const FlatGraph& graph, const Expression& expression) {
  return graph.signals[index(expression.signal)];
}

Dimension dimension_of(const std::string& unit) { return parse_unit(unit).value_or(Unit{}).dimension; }

}  // namespace

int lanes_of(const FlatGraph& graph, const Expression& expression) {
  if (expression.op == Expression::Op::Number) return 1;
  if (expression.op == Expression::Op::Spread) return 0;
  if (expression.op == Expression::Op::Signal) return signal_of(graph, expression).lanes;
  if (expression.op == Expression::Op::Lanes) return static_cast<int>(expression.arguments.size());
  if (expression.op == Expression::Op::Pick) return static_cast<int>(expression.lanes.size());
  int most = 0;
  for (const auto& argument : expression.arguments) most = std::max(most, lanes_of(graph, argument));
  return most;
}

UnitFact product(UnitFact a, UnitFact b, bool divide) {
  if (a.kind == UnitFact::Kind::Unknown || b.kind == UnitFact::Kind::Unknown) return {};
  if (a.kind == UnitFact::Kind::Bare && b.kind == UnitFact::Kind::Bare) return a;
  return UnitFact::known(divide ? a.dimension / b.dimension : a.dimension * b.dimension);
}

std::optional<double> constant_of(const Expression& expression) {
  using Op = Expression::Op;
  if (expression.op == Op::Number) return expression.number;
  if (!is_operator(expression.op) || expression.op == Op::Signal) return std::nullopt;
  OperandRanges in{};
  for (std::size_t i = 0; i < expression.arguments.size(); ++i) {
    const auto value = constant_of(expression.arguments[i]);
    if (!value) return std::nullopt;
    in[i] = Interval::exactly(*value);
  }
  const auto range = range_of(operator_of(expression.op), in);
  return range.single() ? std::optional{range.low} : std::nullopt;
}

bool shares_unit(const Expression& expression, std::size_t i) {
  return !is_operator(expression.op) || operator_of(expression.op).operand_units[i] == 'u';
}

/// The unit that all operands with a unit share; it is bare if none has one.
static UnitFact common_unit(const FlatGraph& graph, const Expression& expression) {
  UnitFact fact = UnitFact::bare();
  for (std::size_t i = 0; i < expression.arguments.size(); ++i) {
    if (!shares_unit(expression, i)) continue;
    const auto other = unit_of(graph, expression.arguments[i]);
    if (fact.kind != UnitFact::Kind::Known && other.kind != UnitFact::Kind::Bare) fact = other;
  }
  return fact;
}

static UnitFact power(const UnitFact& unit, std::optional<double> exponent) {
  if (unit.kind != UnitFact::Kind::Known) return unit;
  return UnitFact::known(exponent ? unit.dimension.pow(*exponent) : Dimension{});
}

UnitFact unit_of(const FlatGraph& graph, const Expression& expression) {
  using Op = Expression::Op;
  if (expression.op == Op::Number)
    return expression.bare ? UnitFact::bare() : UnitFact::known(expression.dimension);
  if (expression.op == Op::Signal) return signal_of(graph, expression).unit;
  if (!is_operator(expression.op)) return common_unit(graph, expression);
  const auto of = [&](std::size_t i) { return unit_of(graph, expression.arguments[i]); };
  switch (operator_of(expression.op).unit) {
    case 'u':
      return common_unit(graph, expression);
    case '*':
      return product(of(0), of(1), false);
    case '/':
      return product(of(0), of(1), true);
    case 'r':
      return power(of(0), 0.5);
    case 'p':
      return power(of(0), constant_of(expression.arguments[1]));
    default:
      return UnitFact::known({});
  }
}

Interval range_of(const FlatGraph& graph, const Expression& expression) {
  using Op = Expression::Op;
  if (expression.op == Op::Number) return Interval::exactly(expression.number);
  if (expression.op == Op::Signal) return signal_of(graph, expression).range;
  if (is_operator(expression.op))
    return range_of(operator_of(expression.op), operand_ranges(graph, expression));
  Interval all = range_of(graph, expression.arguments[0]);
  for (const auto& argument : expression.arguments) all = all.joined(range_of(graph, argument));
  return all;
}

OperandRanges operand_ranges(const FlatGraph& graph, const Expression& expression) {
  OperandRanges in{};
  for (std::size_t i = 0; i < expression.arguments.size(); ++i)
    in[i] = range_of(graph, expression.arguments[i]);
  return in;
}

Interval input_range(const FlatGraph& graph, const FlatNode& node, std::size_t input) {
  if (node.inputs[input]) return range_of(graph, *node.inputs[input]);
  return Interval::exactly(node.type->inputs[input].fallback.value_or(0));
}

NodeSetup setup_of(const FlatNode& node, Hertz sample_rate, int lane) {
  return {Hertz{sample_rate.value / node.divisor}, node.type.get(), {}, node.settings, lane, node.lanes};
}

bool turns(const FlatNode& node) {
  if (node.type->turns) return true;
  for (std::size_t i = 0; i < node.settings.size(); ++i)
    if (node.type->settings[i].name == kMotionSetting) return node.settings[i].text == kRotation;
  return false;
}

PortUnit port_unit(const FlatNode& node, const std::string& declared) {
  if (declared == "any") return {PortUnit::Kind::Any, {}, -1};
  if (declared.empty() || declared.front() != '=') {
    const auto dimension = dimension_of(declared);
    return {PortUnit::Kind::Fixed, turns(node) ? in_rotation(dimension) : dimension, -1};
  }
  const auto end = declared.find_first_of(" /");
  const auto name = declared.substr(1, end == std::string::npos ? end : end - 1);
  const auto factor = end == std::string::npos ? Dimension{} : dimension_of("1" + declared.substr(end));
  for (std::size_t i = 0; i < node.type->settings.size(); ++i) {
    if (node.type->settings[i].name != name) continue;  // a setting gives it: unit = "m/s"
    // If the file does not give it, the numbers are bare and count in the SI unit of wherever they go.
    if (node.settings[i].text.empty() && !node.settings[i].given) return {PortUnit::Kind::Any, {}, -1};
    return {PortUnit::Kind::Fixed, dimension_of(node.settings[i].text) * factor, -1};
  }
  return {PortUnit::Kind::Follows, factor, node.type->input_index(name)};
}

}  // namespace tactus
