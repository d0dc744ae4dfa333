#include <algorithm>
#include <cmath>

#include "engine/graph/file/error_list.h"
#include "engine/graph/file/quantity.h"
#include "engine/graph/file/read_graph.h"
#include "engine/graph/semantics/facts.h"
#include "engine/graph/semantics/operators.h"

namespace tactus {
namespace {

/// As the file at the error's place calls it: "bridge.loss" is the `loss` of a part.
std::string local_name(const std::string& path) { return path.substr(path.rfind('.') + 1); }

/// How messages call an operator: "'+'", "'sqrt'".
std::string quoted(const Operator& type) { return "'" + std::string{type.name} + "'"; }

bool is_even(double exponent) { return std::round(exponent / 2) * 2 == exponent; }

constexpr const char* kOrTurn = ", or write motion = \"rotation\" for angles and torques";

/// Is one of them a length, a velocity, a force, … and the other one what takes its place where things turn?
bool differ_by_arm(const Dimension& a, const Dimension& b) {
  const auto is_turned = [](const Dimension& turned, const Dimension& straight) {
    const auto unit = to_string(turned);
    return !unit.empty() && unit == to_string(in_rotation(straight));
  };
  return is_turned(a, b) || is_turned(b, a);
}

/// Where the units differ by the length of an arm, what to do with it; else `otherwise`.
std::string arm_remedy(const Dimension& wanted, const Dimension& given, const std::string& otherwise) {
  if (!differ_by_arm(wanted, given)) return otherwise;
  const double power = (wanted / given).metre;
  return std::string{power > 0 ? "multiply" : "divide"} + " by the " +
         (std::abs(power) > 1.5 ? "square of the " : "") + "length of the arm, such as 0.1 m";
}

class Checks {
  using Op = Expression::Op;
  using UnitKind = UnitFact::Kind;

 public:
  Checks(const FlatGraph& graph, ErrorList& errors) : graph_(graph), errors_(errors) {}

  void run(const std::vector<PartRange>& part_ranges) {
    for (const auto& node : graph_.nodes)
      for (std::size_t i = 0; i < node.inputs.size(); ++i)
        if (node.inputs[i]) check_input(node, i, *node.inputs[i]);
    for (const auto& signal : graph_.signals)
      if (signal.kind == FlatSignal::Kind::Expression) check_expression(signal);
    for (const auto& given : part_ranges)
      check_part_range(graph_.signals[index(given.signal)].expression, given);
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
    if (rule.kind == PortUnit::Kind::Fixed)
      check_unit_is(expression, rule.dimension, owner, would_turn(node, rule, unit(expression)));
    if (rule.kind == PortUnit::Kind::Follows && rule.follows >= 0 && node.inputs[index(rule.follows)]) {
      const auto followed = unit(*node.inputs[index(rule.follows)]);
      if (followed.kind == UnitKind::Known)
        check_unit_is(expression, followed.dimension * rule.dimension, owner);
    }
    check_range(expression, port, rule, owner);
    if (rule.kind == PortUnit::Kind::Fixed) warn_of_bare_number(expression, rule.dimension, owner);
  }

  /// A number alone where a unit is expected: "time = 6" was perhaps meant as 6 ms.
  void warn_of_bare_number(const Expression& expression, const Dimension& wanted, const std::string& owner) {
    if (wanted.plain()) return;
    if (expression.op == Op::Lanes || expression.op == Op::Spread) {
      for (const auto& lane : expression.arguments) warn_of_bare_number(lane, wanted, owner);
    } else if (expression.op == Op::Number && expression.bare && expression.number != 0) {
      const auto taken = short_number(expression.number) + " " + to_string(wanted);
      errors_.warn(Errc::UnitMismatch, expression.at, owner + " has no unit: it counts as " + taken,
                   "write \"" + taken + "\", or the unit that is meant");
    }
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
    const auto remedy =
        output.declared->plain()
            ? "give it a unit, as in unit = \"" + to_string(fact.dimension) + "\", or scale it to full scale"
            : "fix 'from' or 'unit'";
    errors_.add(Errc::UnitMismatch, output.at,
                "output '" + output.name + "' is " + unit_phrase(*output.declared) + ", but its source is " +
                    unit_phrase(fact.dimension),
                arm_remedy(*output.declared, fact.dimension, remedy));
  }

  void check_lanes(const Expression& expression, int wanted) {
    const int found = lanes_of(graph_, expression);
    if (found > 1 && wanted > 1 && found != wanted)
      return errors_.add(Errc::OutOfRange, expression.at,
                         std::to_string(found) + " lanes are combined with " + std::to_string(wanted),
                         "give both the same number of lanes, or put a 'mix' between them");
    if (expression.op == Op::Signal) return;
    if (expression.op == Op::Lanes) return check_lanes_of_list(expression);
    if (expression.op == Op::Pick) return check_picked_lanes(expression);
    for (const auto& argument : expression.arguments) check_lanes(argument, wanted);
  }

  void check_lanes_of_list(const Expression& list) {
    for (const auto& lane : list.arguments)
      if (const int found = lanes_of(graph_, lane); found > 1)
        errors_.add(Errc::OutOfRange, lane.at,
                    "this is one lane of a list, but has " + std::to_string(found) + " lanes itself",
                    "use a 'mix' of it here, or remove it from the list");
  }

  void check_picked_lanes(const Expression& pick) {
    const auto& signal = pick.arguments.front();
    const int there_are = lanes_of(graph_, signal), highest = *std::ranges::max_element(pick.lanes);
    if (highest < there_are || signal.signal == FlatGraph::kMissing) return;
    errors_.add(Errc::OutOfRange, pick.at, "'" + signal.name + "' has no lane " + std::to_string(highest),
                there_are == 1 ? "it has one lane; remove the brackets"
                               : "its lanes are 0 to " + std::to_string(there_are - 1));
  }

  void check_units(const Expression& expression) {
    const Expression* first = nullptr;
    for (std::size_t i = 0; i < expression.arguments.size(); ++i) {
      const auto& argument = expression.arguments[i];
      if (unit(argument).kind != UnitKind::Known || !shares_unit(expression, i)) continue;
      if (first == nullptr) first = &argument;
      check_agrees(argument, *first, expression.op);
    }
    if (is_operator(expression.op) && expression.op != Op::Signal)
      check_operator(expression, operator_of(expression.op));
    for (const auto& argument : expression.arguments) check_units(argument);
  }

  void check_operator(const Expression& expression, const Operator& type) {
    if (type.op == Op::Divide) check_divisor(expression.arguments[1]);
    for (std::size_t i = 0; i < expression.arguments.size(); ++i)
      if (type.operand_units[i] == '1') check_plain(expression.arguments[i], type);
    if (type.unit == 'r') check_root(expression.arguments[0], type);
    if (type.unit == 'p') check_power(expression, type);
    check_domain(expression, type);
  }

  /// A signal may pass through 0, which then counts as 0; what is nothing else was not meant.
  void check_divisor(const Expression& expression) {
    const auto range = range_of(graph_, expression);
    if (range.low == 0 && range.high == 0)
      errors_.add(Errc::OutOfRange, expression.at, "the divisor is always 0", "divide by another number");
  }

  void check_plain(const Expression& argument, const Operator& type) {
    const auto fact = unit(argument);
    if (fact.kind != UnitKind::Known || fact.dimension.plain()) return;
    errors_.add(Errc::UnitMismatch, argument.at,
                quoted(type) + " takes a plain number, but this is " + unit_phrase(fact.dimension),
                "divide by a quantity in " + to_string(fact.dimension));
  }

  void check_root(const Expression& argument, const Operator& type) {
    const auto fact = unit(argument);
    if (fact.kind != UnitKind::Known) return;
    const auto& d = fact.dimension;
    if (is_even(d.metre) && is_even(d.kilogram) && is_even(d.second) && is_even(d.ampere)) return;
    errors_.add(Errc::UnitMismatch, argument.at,
                quoted(type) + " needs a unit with even powers, such as m^2/s^2, but this is " +
                    unit_phrase(fact.dimension),
                "divide by a quantity in " + to_string(fact.dimension));
  }

  void check_power(const Expression& expression, const Operator& type) {
    const auto fact = unit(expression.arguments[0]);
    if (fact.kind != UnitKind::Known || fact.dimension.plain()) return;
    const auto exponent = constant_of(expression.arguments[1]);
    if (exponent && std::round(*exponent) == *exponent) return;
    errors_.add(
        Errc::UnitMismatch, expression.arguments[1].at,
        quoted(type) + " raises what is " + unit_phrase(fact.dimension) + " to whole constant powers only",
        "divide the first value by a quantity in " + to_string(fact.dimension));
  }

  /// A signal may leave the domain, which is then a fault; what is never inside was not meant.
  void check_domain(const Expression& expression, const Operator& type) {
    if (*type.domain_text == '\0') return;
    const auto in = operand_ranges(graph_, expression);
    if (!is_outside(type, in)) return;
    const auto always = in[0].single() ? " " + short_number(in[0].low) : "";
    errors_.add(Errc::OutOfRange, expression.at,
                type.use() + " is always outside its domain: " + type.domain_text +
                    (type.operands == 1 && in[0].single() ? ", but x is" + always : ""),
                "give it a value inside the domain");
  }

  void check_agrees(const Expression& expression, const Expression& first, Expression::Op op) {
    const auto a = unit(first).dimension;
    const auto b = unit(expression).dimension;
    const bool by_two_pi =
        (is_frequency(a) && is_angular_velocity(b)) || (is_angular_velocity(a) && is_frequency(b));
    if (a == b && !by_two_pi) return;
    const std::string meets = op == Op::Add                   ? "is added to"
                              : op == Op::Subtract            ? "is taken from"
                              : op == Op::Lanes               ? "is in a list with"
                              : op == Op::Spread              ? "is in a spread with"
                              : operator_of(op).is_function() ? "meets in " + quoted(operator_of(op))
                                                              : "is compared with";
    errors_.add(Errc::UnitMismatch, expression.at,
                "this is " + unit_phrase(b) + ", but it " + meets + " what is " + unit_phrase(a),
                by_two_pi ? "multiply what is in Hz by (2 * pi * 1 rad)"
                : op == Op::Lanes || op == Op::Spread
                    ? "give both the same unit"
                    : "multiply one of them by a quantity that turns its unit into the other's");
  }

  /// Of a node that could turn as well: where an angle or a torque comes in.
  static bool would_turn(const FlatNode& node, const PortUnit& rule, const UnitFact& fact) {
    return find_named(node.type->settings, kMotionSetting) != nullptr && fact.kind == UnitKind::Known &&
           to_string(fact.dimension) == to_string(in_rotation(rule.dimension));
  }

  /// `turns`: what is given fits a node that turns.
  void check_unit_is(const Expression& expression, const Dimension& wanted, const std::string& owner,
                     bool turns = false) {
    const auto fact = unit(expression);
    if (fact.kind != UnitKind::Known) return;
    if (is_frequency(wanted) && is_angular_velocity(fact.dimension))
      return errors_.add(Errc::UnitMismatch, expression.at, owner + " is in Hz, but this is in rad/s",
                         "divide by (2 * pi) for turns per second, or by 1 rad to take the number as it is");
    if (fact.dimension == wanted) return;
    errors_.add(Errc::UnitMismatch, expression.at,
                owner + " is " + unit_phrase(wanted) + ", but this is " + unit_phrase(fact.dimension),
                arm_remedy(wanted, fact.dimension,
                           wanted.plain() ? "divide by a quantity in " + to_string(fact.dimension)
                                          : "give a quantity in " + to_string(wanted)) +
                    (turns ? kOrTurn : ""));
  }

  /// Each lane of a list by itself.
  void check_part_range(const Expression& expression, const PartRange& given) {
    if (expression.op == Op::Lanes || expression.op == Op::Spread) {
      for (const auto& lane : expression.arguments) check_part_range(lane, given);
      return;
    }
    const auto fact = unit(expression);
    if (fact.kind == UnitKind::Known && !(fact.dimension == given.unit.dimension)) return;  // reported
    const auto found = range_of(graph_, expression);
    if (!given.excludes(found)) return;
    errors_.add(Errc::OutOfRange, expression.at, given.owner + " cannot be " + in_unit(found.low, given.unit),
                given.is_fraction(found) ? kGiveWholeNumber
                                         : limits_text(given.range.low, given.range.high, given.unit));
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

void check_facts(const FlatGraph& graph, const std::vector<PartRange>& part_ranges, ErrorList& errors) {
  Checks{graph, errors}.run(part_ranges);
}

}  // namespace tactus
