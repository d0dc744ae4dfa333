#include "engine/graph/semantics/facts.h"

#include <algorithm>

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
  int most = 0;
  for (const auto& argument : expression.arguments) most = std::max(most, lanes_of(graph, argument));
  return most;
}

UnitFact product(UnitFact a, UnitFact b, bool divide) {
  if (a.kind == UnitFact::Kind::Unknown || b.kind == UnitFact::Kind::Unknown) return {};
  if (a.kind == UnitFact::Kind::Bare && b.kind == UnitFact::Kind::Bare) return a;
  return UnitFact::known(divide ? a.dimension / b.dimension : a.dimension * b.dimension);
}

UnitFact unit_of(const FlatGraph& graph, const Expression& expression) {
  using Op = Expression::Op;
  const auto of = [&](std::size_t i) { return unit_of(graph, expression.arguments[i]); };
  switch (expression.op) {
    case Op::Number:
      return expression.bare ? UnitFact::bare() : UnitFact::known(expression.dimension);
    case Op::Signal:
      return signal_of(graph, expression).unit;
    case Op::Negate:
    case Op::Abs:
      return of(0);
    case Op::Multiply:
    case Op::Divide:
      return product(of(0), of(1), expression.op == Op::Divide);
    default:
      break;
  }
  UnitFact fact = UnitFact::bare();
  for (const auto& argument : expression.arguments) {
    const auto other = unit_of(graph, argument);
    if (fact.kind != UnitFact::Kind::Known && other.kind != UnitFact::Kind::Bare) fact = other;
  }
  return fact;
}

Interval range_of(const FlatGraph& graph, const Expression& expression) {
  using Op = Expression::Op;
  if (expression.op == Op::Number) return Interval::exactly(expression.number);
  if (expression.op == Op::Signal) return signal_of(graph, expression).range;
  const auto of = [&](std::size_t i) { return range_of(graph, expression.arguments[i]); };
  const auto first = of(0);
  if (expression.op != Op::Lanes && expression.op != Op::Spread)
    return apply(expression.op, first, expression.arguments.size() > 1 ? of(1) : first);
  Interval all = first;
  for (std::size_t i = 1; i < expression.arguments.size(); ++i) all = all.joined(of(i));
  return all;
}

Interval input_range(const FlatGraph& graph, const FlatNode& node, std::size_t input) {
  if (node.inputs[input]) return range_of(graph, *node.inputs[input]);
  return Interval::exactly(node.type->inputs[input].fallback.value_or(0));
}

NodeSetup setup_of(const FlatNode& node, Hertz sample_rate, int lane) {
  return {Hertz{sample_rate.value / node.divisor}, node.type.get(), {}, node.settings, lane};
}

PortUnit port_unit(const FlatNode& node, const std::string& declared) {
  if (declared == "any") return {PortUnit::Kind::Any, {}, -1};
  if (declared.empty() || declared.front() != '=') return {PortUnit::Kind::Fixed, dimension_of(declared), -1};
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
