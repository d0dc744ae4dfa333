#include "engine/graph/file/error_list.h"
#include "engine/graph/file/quantity.h"
#include "engine/graph/semantics/facts.h"

namespace tactus {
namespace {

/// As the file at the error's place calls it: "bridge.loss" is the `loss` of a part.
std::string local_name(const std::string& path) { return path.substr(path.rfind('.') + 1); }

bool adds_or_compares(Expression::Op op) {
  using Op = Expression::Op;
  return op == Op::Add || op == Op::Subtract || op == Op::Min || op == Op::Max || op == Op::Lanes ||
         op == Op::Spread;
}

class Checks {
  using Op = Expression::Op;
  using UnitKind = UnitFact::Kind;

 public:
  Checks(const FlatGraph& graph, ErrorList& errors) : graph_(graph), errors_(errors) {}

  void run() {
    for (const auto& node : graph_.nodes)
      for (std::size_t i = 0; i < node.inputs.size(); ++i)
        if (node.inputs[i]) check_input(node, i, *node.inputs[i]);
    for (const auto& signal : graph_.signals)
      if (signal.kind == FlatSignal::Kind::Expression) check_expression(signal);
    for (const auto& output : graph_.outputs) check_output(output);
  }

 private:
  UnitFact unit(const Expression& expression) const { return unit_of(graph_, expression); }

  void check_input(const FlatNode& node, std::size_t i, const Expression& expression) {
    const auto& port = node.type->inputs[i];
    check_units(expression);
    check_lanes(expression, node.lanes);
    const auto rule = port_unit(node, port.unit);
    const auto owner = "'" + port.name + "' of " + node.label();
    if (rule.kind == PortUnit::Kind::Fixed) check_unit_is(expression, rule.dimension, owner);
    if (rule.kind == PortUnit::Kind::Follows && rule.follows >= 0 && node.inputs[index(rule.follows)]) {
      const auto followed = unit(*node.inputs[index(rule.follows)]);
      if (followed.kind == UnitKind::Known)
        check_unit_is(expression, followed.dimension * rule.dimension, owner);
    }
    check_range(expression, port, rule, owner);
  }

  void check_expression(const FlatSignal& signal) {
    check_units(signal.expression);
    check_lanes(signal.expression, signal.lanes);
    if (signal.declared)
      check_unit_is(signal.expression, *signal.declared, "'" + local_name(signal.path) + "'");
  }

  void check_output(const FlatOutput& output) {
    check_units(output.expression);
    check_lanes(output.expression, output.lanes);
    if (!output.declared) return;
    const auto fact = unit(output.expression);
    if (fact.kind != UnitKind::Known || fact.dimension == *output.declared) return;
    errors_.add(Errc::UnitMismatch, output.at,
                "output '" + output.name + "' is " + unit_phrase(*output.declared) + ", but its source is " +
                    unit_phrase(fact.dimension),
                output.declared->plain() ? "give it a unit, as in unit = \"" + to_string(fact.dimension) +
                                               "\", or scale it to full scale"
                                         : "fix 'from' or 'unit'");
  }

  void check_lanes(const Expression& expression, int wanted) {
    const int found = lanes_of(graph_, expression);
    if (found > 1 && wanted > 1 && found != wanted)
      return errors_.add(Errc::OutOfRange, expression.at,
                         std::to_string(found) + " lanes are combined with " + std::to_string(wanted),
                         "give both the same number of lanes, or put a 'mix' between them");
    if (expression.op == Op::Signal) return;
    if (expression.op == Op::Lanes) return check_lanes_of_list(expression);
    for (const auto& argument : expression.arguments) check_lanes(argument, wanted);
  }

  void check_lanes_of_list(const Expression& list) {
    for (const auto& lane : list.arguments)
      if (const int found = lanes_of(graph_, lane); found > 1)
        errors_.add(Errc::OutOfRange, lane.at,
                    "this is one lane of a list, but has " + std::to_string(found) + " lanes itself",
                    "use a 'mix' of it here, or remove it from the list");
  }

  void check_units(const Expression& expression) {
    if (adds_or_compares(expression.op)) {
      const Expression* first = nullptr;
      for (const auto& argument : expression.arguments) {
        if (unit(argument).kind != UnitKind::Known) continue;
        if (first == nullptr) first = &argument;
        check_agrees(argument, *first, expression.op);
      }
    }
    if (expression.op == Op::Divide) check_divisor(expression.arguments[1]);
    for (const auto& argument : expression.arguments) check_units(argument);
  }

  /// A signal may pass through 0, which then counts as 0; what is nothing else was not meant.
  void check_divisor(const Expression& expression) {
    const auto range = range_of(graph_, expression);
    if (range.low == 0 && range.high == 0)
      errors_.add(Errc::OutOfRange, expression.at, "the divisor is always 0", "divide by another number");
  }

  void check_agrees(const Expression& expression, const Expression& first, Expression::Op op) {
    const auto a = unit(first).dimension;
    const auto b = unit(expression).dimension;
    if (a == b) return;
    const char* meets = op == Op::Add        ? "is added to"
                        : op == Op::Subtract ? "is taken from"
                        : op == Op::Lanes    ? "is in a list with"
                        : op == Op::Spread   ? "is in a spread with"
                                             : "is compared with";
    errors_.add(Errc::UnitMismatch, expression.at,
                "this is " + unit_phrase(b) + ", but it " + meets + " what is " + unit_phrase(a),
                op == Op::Lanes || op == Op::Spread
                    ? "give both the same unit"
                    : "multiply one of them by a quantity that turns its unit into the other's");
  }

  void check_unit_is(const Expression& expression, const Dimension& wanted, const std::string& owner) {
    const auto fact = unit(expression);
    if (fact.kind != UnitKind::Known || fact.dimension == wanted) return;
    errors_.add(Errc::UnitMismatch, expression.at,
                owner + " is " + unit_phrase(wanted) + ", but this is " + unit_phrase(fact.dimension),
                wanted.plain() ? "divide by a quantity in " + to_string(fact.dimension)
                               : "give a quantity in " + to_string(wanted));
  }

  void check_range(const Expression& expression, const InputPort& port, const PortUnit& rule,
                   const std::string& owner) {
    const auto found = range_of(graph_, expression);
    // Only what the file fixes can be wrong before it runs: numbers, and controls with a range.
    if (!found.bounded()) return;
    if (found.low >= port.low && found.high <= port.high) return;
    if (!found.single() && found.low <= port.high && found.high >= port.low) return;  // clamped while it runs
    const Unit unit{rule.kind == PortUnit::Kind::Fixed ? rule.dimension : Dimension{}};
    errors_.add(Errc::OutOfRange, expression.at, owner + " cannot be " + in_unit(found.low, unit),
                limits_text(port.low, port.high, unit));
  }

  const FlatGraph& graph_;
  ErrorList& errors_;
};

}  // namespace

void check_facts(const FlatGraph& graph, ErrorList& errors) { Checks{graph, errors}.run(); }

}  // namespace tactus
