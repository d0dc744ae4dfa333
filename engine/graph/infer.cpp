#include "engine/graph/infer.h"

#include <cmath>
#include <set>

#include "engine/graph/quantity.h"

namespace tactus {
namespace {

std::string spoken(const Dimension& dimension) {
  return dimension.plain() ? "a plain number" : "in " + to_string(dimension);
}

/// The unit of a port: fixed, unchecked, or that of another port times something ("=in/s").
struct PortUnit {
  enum class Kind { Any, Fixed, Follows } kind = Kind::Fixed;
  Dimension dimension;
  int follows = -1;
};

Dimension dimension_of(const std::string& unit) { return parse_unit(unit).value_or(Unit{}).dimension; }

PortUnit port_unit(const FlatNode& node, const std::string& text) {
  if (text == "any") return {PortUnit::Kind::Any, {}, -1};
  if (text.empty() || text.front() != '=') return {PortUnit::Kind::Fixed, dimension_of(text), -1};
  const auto end = text.find_first_of(" /");
  const auto name = text.substr(1, end == std::string::npos ? end : end - 1);
  const auto factor = end == std::string::npos ? Dimension{} : dimension_of("1" + text.substr(end));
  for (std::size_t i = 0; i < node.type->settings.size(); ++i)  // a word of the file says it: unit = "m/s"
    if (node.type->settings[i].name == name)
      return {PortUnit::Kind::Fixed, dimension_of(node.settings[i].text) * factor, -1};
  return {PortUnit::Kind::Follows, factor, node.type->input_index(name)};
}

class Inference {
 public:
  explicit Inference(FlatGraph& graph) : graph_(graph) {}

  std::vector<Error> run() {
    infer_lanes();
    infer_units();
    infer_ranges();
    for (auto& output : graph_.outputs)
      output.dimension = output.declared.value_or(unit(output.term).dimension);
    for (auto& node : graph_.nodes)
      for (std::size_t i = 0; i < node.inputs.size(); ++i) node.ranges.push_back(input_range(node, i));
    check();
    return std::move(errors_);
  }

 private:
  FlatSignal& signal(int id) { return graph_.signals[static_cast<std::size_t>(id)]; }

  void complain(Errc code, const Source& at, std::string what, std::string remedy) {
    Error error{code, at.text(), std::move(what), std::move(remedy)};
    if (reported_.insert(error.where + error.what).second) errors_.push_back(std::move(error));
  }

  // ---- lanes
  // -----------------------------------------------------------------------------------------------

  /// 0: any number of lanes fits (a spread).
  int lanes(const Term& term) {
    if (term.op == Term::Op::Number) return 1;
    if (term.op == Term::Op::Spread) return 0;
    if (term.op == Term::Op::Signal) return signal(term.signal).lanes;
    if (term.op == Term::Op::Lanes) return static_cast<int>(term.arguments.size());
    int most = 0;
    for (const auto& argument : term.arguments) most = std::max(most, lanes(argument));
    return most;
  }

  void infer_lanes() {
    // Lanes only grow, and by no more than the widest list, so this ends.
    for (bool changed = true; changed;) {
      changed = false;
      const auto grow = [&](int& lanes_now, int wanted) {
        if (wanted > lanes_now) {
          lanes_now = wanted;
          changed = true;
        }
      };
      for (auto& node : graph_.nodes) {
        grow(node.lanes, node.voices);
        for (const auto& input : node.inputs)
          if (input) grow(node.lanes, lanes(*input));
        for (const int output : node.outputs)
          grow(signal(output).lanes, node.type->name == "mix" ? 1 : node.lanes);
      }
      for (auto& s : graph_.signals)
        if (s.kind == FlatSignal::Kind::Expression) grow(s.lanes, lanes(s.term));
    }
    for (auto& output : graph_.outputs) output.lanes = std::max(1, lanes(output.term));
  }

  void check_lanes(const Term& term, int wanted) {
    const int found = lanes(term);
    if (found > 1 && wanted > 1 && found != wanted)
      complain(Errc::OutOfRange, term.at, std::to_string(found) + " lanes meet " + std::to_string(wanted),
               "give both the same number of lanes, or put a 'mix' between them");
    if (term.op == Term::Op::Signal || term.op == Term::Op::Lanes) return;
    for (const auto& argument : term.arguments) check_lanes(argument, wanted);
  }

  // ---- units
  // -----------------------------------------------------------------------------------------------

  UnitFact unit(const Term& term) {
    using Op = Term::Op;
    switch (term.op) {
      case Op::Number:
        return term.bare ? UnitFact::bare() : UnitFact::known(term.dimension);
      case Op::Signal:
        return signal(term.signal).unit;
      case Op::Negate:
      case Op::Abs:
        return unit(term.arguments[0]);
      case Op::Multiply:
      case Op::Divide:
        return product(unit(term.arguments[0]), unit(term.arguments[1]), term.op == Op::Divide);
      default:
        break;
    }
    UnitFact fact = UnitFact::bare();
    for (const auto& argument : term.arguments) {
      const auto other = unit(argument);
      if (fact.kind != UnitFact::Kind::Known && other.kind != UnitFact::Kind::Bare) fact = other;
    }
    return fact;
  }

  static UnitFact product(UnitFact a, UnitFact b, bool divide) {
    if (a.kind == UnitFact::Kind::Unknown || b.kind == UnitFact::Kind::Unknown) return {};
    if (a.kind == UnitFact::Kind::Bare && b.kind == UnitFact::Kind::Bare) return a;
    return UnitFact::known(divide ? a.dimension / b.dimension : a.dimension * b.dimension);
  }

  UnitFact output_unit(const FlatNode& node, int port) {
    const auto rule = port_unit(node, node.type->outputs[static_cast<std::size_t>(port)].unit);
    if (rule.kind == PortUnit::Kind::Any) return UnitFact::bare();
    if (rule.kind == PortUnit::Kind::Fixed) return UnitFact::known(rule.dimension);
    if (rule.follows < 0) return UnitFact::bare();
    const auto& input = node.inputs[static_cast<std::size_t>(rule.follows)];
    const auto followed = input ? unit(*input) : UnitFact::bare();
    return rule.dimension.plain() ? followed : product(followed, UnitFact::known(rule.dimension), false);
  }

  void infer_units() {
    for (auto& s : graph_.signals)
      if (s.declared) s.unit = UnitFact::known(*s.declared);
    for (bool changed = true; changed;) {
      changed = false;
      for (auto& s : graph_.signals) {
        if (s.unit.kind == UnitFact::Kind::Known) continue;
        UnitFact fact = s.unit;
        if (s.kind == FlatSignal::Kind::Expression) fact = unit(s.term);
        if (s.kind == FlatSignal::Kind::NodeOutput)
          fact = output_unit(graph_.nodes[static_cast<std::size_t>(s.index)], s.port);
        if (fact == s.unit || fact.kind == UnitFact::Kind::Unknown) continue;
        s.unit = fact;
        changed = true;
      }
    }
  }

  void check_units(const Term& term) {
    if (term.op == Term::Op::Add || term.op == Term::Op::Subtract || term.op == Term::Op::Min ||
        term.op == Term::Op::Max || term.op == Term::Op::Lanes || term.op == Term::Op::Spread) {
      const Term* first = nullptr;
      for (const auto& argument : term.arguments) {
        if (unit(argument).kind != UnitFact::Kind::Known) continue;
        if (first == nullptr) first = &argument;
        const auto a = unit(*first).dimension;
        const auto b = unit(argument).dimension;
        if (!(a == b))
          complain(Errc::UnitMismatch, argument.at,
                   "this is " + spoken(b) + ", but it is added to or compared with what is " + spoken(a),
                   "multiply one of them by a quantity that turns its unit into the other's");
      }
    }
    for (const auto& argument : term.arguments) check_units(argument);
  }

  void check_unit_is(const Term& term, const Dimension& wanted, const std::string& owner) {
    const auto fact = unit(term);
    if (fact.kind == UnitFact::Kind::Known && !(fact.dimension == wanted))
      complain(Errc::UnitMismatch, term.at,
               owner + " is " + spoken(wanted) + ", but this is " + spoken(fact.dimension),
               wanted.plain() ? "divide by a quantity in " + to_string(fact.dimension)
                              : "give a quantity in " + to_string(wanted));
  }

  // ---- ranges
  // ----------------------------------------------------------------------------------------------

  Interval range(const Term& term) {
    using Op = Term::Op;
    const auto argument = [&](std::size_t i) { return range(term.arguments[i]); };
    switch (term.op) {
      case Op::Number:
        return Interval::exactly(term.number);
      case Op::Signal:
        return signal(term.signal).range;
      case Op::Negate:
        return -argument(0);
      case Op::Add:
        return argument(0) + argument(1);
      case Op::Subtract:
        return argument(0) - argument(1);
      case Op::Multiply:
        return argument(0) * argument(1);
      case Op::Divide:
        return argument(0) / argument(1);
      case Op::Min:
        return min(argument(0), argument(1));
      case Op::Max:
        return max(argument(0), argument(1));
      case Op::Abs:
        return abs(argument(0));
      case Op::Lanes:
      case Op::Spread:
        break;
    }
    Interval all = argument(0);
    for (std::size_t i = 1; i < term.arguments.size(); ++i) all = all.joined(argument(i));
    return all;
  }

  void infer_ranges() {
    // Each pass narrows further along chains; loops that would go on for ever are cut off, which is safe.
    for (int pass = 0; pass < 16; ++pass) {
      bool changed = false;
      for (auto& s : graph_.signals) {
        Interval found = s.range;
        if (s.kind == FlatSignal::Kind::Expression) found = range(s.term);
        if (s.kind == FlatSignal::Kind::NodeOutput)
          found = output_range(graph_.nodes[static_cast<std::size_t>(s.index)], s.port);
        if (found.low == s.range.low && found.high == s.range.high) continue;
        s.range = found;
        changed = true;
      }
      if (!changed) return;
    }
  }

  Interval input_range(const FlatNode& node, std::size_t i) {
    if (node.inputs[i]) return range(*node.inputs[i]);
    return Interval::exactly(node.type->inputs[i].fallback.value_or(0));
  }

  Interval output_range(const FlatNode& node, int port) {
    const auto& type = *node.type;
    if (!type.range) return type.outputs[static_cast<std::size_t>(port)].range;
    NodeSetup setup;
    setup.type = &type;
    setup.settings = node.settings;
    for (std::size_t i = 0; i < node.inputs.size(); ++i) {
      setup.inputs.push_back({input_range(node, i), std::nullopt, node.inputs[i].has_value()});
    }
    return type.range(port, setup);
  }

  // ---- checks
  // ----------------------------------------------------------------------------------------------

  void check() {
    for (const auto& node : graph_.nodes) check_node(node);
    for (const auto& s : graph_.signals) {
      if (s.kind != FlatSignal::Kind::Expression) continue;
      check_units(s.term);
      check_lanes(s.term, s.lanes);
      if (s.declared) check_unit_is(s.term, *s.declared, "'" + s.path + "'");
    }
    for (const auto& output : graph_.outputs) {
      check_units(output.term);
      check_lanes(output.term, output.lanes);
      if (!output.declared) continue;
      const auto fact = unit(output.term);
      if (fact.kind == UnitFact::Kind::Known && !(fact.dimension == *output.declared))
        complain(Errc::UnitMismatch, output.at,
                 "output '" + output.name + "' is " + spoken(*output.declared) +
                     ", but it is given what is " + spoken(fact.dimension),
                 output.declared->plain() ? "give it a unit, as in unit = \"" + to_string(fact.dimension) +
                                                "\", or scale it to full scale"
                                          : "mend 'from' or 'unit'");
    }
  }

  void check_node(const FlatNode& node) {
    const auto& type = *node.type;
    for (std::size_t i = 0; i < type.inputs.size(); ++i) {
      if (!node.inputs[i]) continue;
      const auto& term = *node.inputs[i];
      const auto& port = type.inputs[i];
      check_units(term);
      if (type.name != "mix") check_lanes(term, node.lanes);
      const auto rule = port_unit(node, port.unit);
      const auto owner = "'" + port.name + "' of " + type.name + " '" + node.path + "'";
      if (rule.kind == PortUnit::Kind::Fixed) check_unit_is(term, rule.dimension, owner);
      if (rule.kind == PortUnit::Kind::Follows && rule.follows >= 0 &&
          node.inputs[static_cast<std::size_t>(rule.follows)]) {
        const auto followed = unit(*node.inputs[static_cast<std::size_t>(rule.follows)]);
        if (followed.kind == UnitFact::Kind::Known)
          check_unit_is(term, followed.dimension * rule.dimension, owner);
      }
      check_range(term, port, rule, owner);
    }
  }

  void check_range(const Term& term, const InputPort& port, const PortUnit& rule, const std::string& owner) {
    const auto found = range(term);
    // Only what the file fixes can be wrong before it runs: numbers, and controls with a range.
    if (!found.bounded()) return;
    if (found.low >= port.low && found.high <= port.high) return;
    if (!found.single() && found.low <= port.high && found.high >= port.low) return;  // clamped while it runs
    const auto& unit_text = rule.kind == PortUnit::Kind::Fixed ? to_string(rule.dimension) : std::string{};
    const auto number = [&](double x) {
      return short_number(x) + (unit_text.empty() ? "" : " " + unit_text);
    };
    complain(Errc::OutOfRange, term.at, owner + " cannot be " + number(found.low),
             std::isinf(port.high)  ? "it must be at least " + number(port.low)
             : std::isinf(port.low) ? "it must be at most " + number(port.high)
                                    : "it must be between " + number(port.low) + " and " + number(port.high));
  }

  FlatGraph& graph_;
  std::vector<Error> errors_;
  std::set<std::string> reported_;
};

}  // namespace

std::vector<Error> infer(FlatGraph& graph) { return Inference{graph}.run(); }

}  // namespace tactus
