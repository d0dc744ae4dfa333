#include <limits>
#include <unordered_map>
#include <utility>
#include <vector>

#include "engine/graph/semantics/facts.h"

namespace tactus {
namespace {

void add_signals(const Expression& expression, std::vector<int>& signals) {
  if (expression.op == Expression::Op::Signal) signals.push_back(expression.signal);
  for (const auto& argument : expression.arguments) add_signals(argument, signals);
}

/// What a signal is made of. The first output of a node represents all that it reads.
std::vector<int> needs_of(const FlatGraph& graph, int id) {
  const auto& signal = graph.signals[index(id)];
  std::vector<int> needs;
  if (signal.kind == FlatSignal::Kind::Expression) add_signals(signal.expression, needs);
  if (signal.kind != FlatSignal::Kind::NodeOutput) return needs;
  const auto& node = graph.nodes[index(signal.index)];
  if (id != node.outputs.front()) return {node.outputs.front()};
  for (const auto& input : node.inputs)
    if (input) add_signals(*input, needs);
  return needs;
}

/// All signals, each behind those that it is made of, loops aside: so that facts run along the longest chain
/// in one pass, whatever order a file is written in.
std::vector<int> dependency_order(const FlatGraph& graph) {
  std::vector<std::vector<int>> needs;
  for (std::size_t id = 0; id < graph.signals.size(); ++id)
    needs.push_back(needs_of(graph, static_cast<int>(id)));
  std::vector<int> order;
  for (const auto& component : strong_components(needs, Roots::FirstToLast))
    order.insert(order.end(), component.begin(), component.end());
  return order;
}

class Inference {
  using SignalKind = FlatSignal::Kind;
  using UnitKind = UnitFact::Kind;

 public:
  Inference(FlatGraph& graph, const std::vector<PartRange>& part_ranges)
      : graph_(graph), order_(dependency_order(graph)) {
    for (const auto& given : part_ranges) part_ranges_.emplace(given.signal, &given);
  }

  void run() {
    infer_lanes();
    infer_units();
    convert_angles();
    infer_ranges();
    for (auto& output : graph_.outputs)
      output.dimension = output.declared.value_or(unit_of(graph_, output.expression).dimension);
    for (auto& node : graph_.nodes)
      for (std::size_t i = 0; i < node.inputs.size(); ++i)
        node.ranges.push_back(input_range(graph_, node, i));
  }

 private:
  FlatSignal& signal(int id) { return graph_.signals[index(id)]; }
  const FlatNode& node_of(const FlatSignal& output) const { return graph_.nodes[index(output.index)]; }

  /// Passes over all signals until none changes.
  template <class Update>
  void repeat(Update update, int most_passes = std::numeric_limits<int>::max()) {
    bool changed = true;
    for (int pass = 0; changed && pass < most_passes; ++pass) {
      changed = false;
      for (const int id : order_) changed |= update(signal(id), id);
    }
  }

  // ---- lanes: they only grow, and by no more than the widest list, so this ends

  void infer_lanes() {
    repeat([this](FlatSignal& s, int id) {
      if (s.kind == SignalKind::Expression) return grow(s.lanes, lanes_of(graph_, s.expression));
      return s.kind == SignalKind::NodeOutput && grow_node_lanes(s, id);
    });
    for (auto& output : graph_.outputs) output.lanes = std::max(1, lanes_of(graph_, output.expression));
  }

  bool grow_node_lanes(const FlatSignal& output, int id) {
    auto& node = graph_.nodes[index(output.index)];
    if (id != node.outputs.front()) return false;
    bool changed = grow(node.lanes, node.voices);
    for (const auto& input : node.inputs)
      if (input) changed |= grow(node.lanes, lanes_of(graph_, *input));
    for (const int other : node.outputs)
      changed |= grow(signal(other).lanes, node.type->reduces_lanes ? 1 : node.lanes);
    return changed;
  }

  static bool grow(int& lanes, int wanted) {
    if (wanted <= lanes) return false;
    lanes = wanted;
    return true;
  }

  // ---- units

  void infer_units() {
    for (auto& s : graph_.signals)
      if (s.declared) s.unit = UnitFact::known(*s.declared);
    repeat([this](FlatSignal& s, int) {
      if (s.unit.kind == UnitKind::Known) return false;
      UnitFact fact = s.unit;
      if (s.kind == SignalKind::Expression) fact = unit_of(graph_, s.expression);
      if (s.kind == SignalKind::NodeOutput) fact = output_unit(node_of(s), s.port);
      if (fact == s.unit || fact.kind == UnitKind::Unknown) return false;
      s.unit = fact;
      return true;
    });
  }

  UnitFact output_unit(const FlatNode& node, int port) const {
    const auto rule = port_unit(node, node.type->outputs[index(port)].unit);
    if (rule.kind == PortUnit::Kind::Any) return UnitFact::bare();
    if (rule.kind == PortUnit::Kind::Fixed) return UnitFact::known(rule.dimension);
    if (rule.follows < 0) return UnitFact::bare();
    const auto& input = node.inputs[index(rule.follows)];
    const auto followed = input ? unit_of(graph_, *input) : UnitFact::bare();
    return rule.dimension.plain() ? followed : product(followed, UnitFact::known(rule.dimension), false);
  }

  // ---- quantities: from rad/s to Hz where a frequency is expected, from Hz to rad/s where an angular
  // velocity is

  void convert_angles() {
    for (auto& node : graph_.nodes)
      for (std::size_t i = 0; i < node.inputs.size(); ++i) {
        const auto rule = port_unit(node, node.type->inputs[i].unit);
        if (node.inputs[i] && rule.kind == PortUnit::Kind::Fixed) convert(*node.inputs[i], rule.dimension);
      }
    for (auto& s : graph_.signals)
      if (s.kind == SignalKind::Expression && s.declared) convert(s.expression, *s.declared);
  }

  static void convert(Expression& expression, const Dimension& wanted) {
    using Op = Expression::Op;
    for (std::size_t i = 0; i < expression.arguments.size(); ++i)
      if (shares_unit(expression, i)) convert(expression.arguments[i], wanted);
    if (expression.op == Op::Number && !expression.bare && expression.dimension == wanted) {
      expression.number = converted(expression.number, expression.dimension, wanted);
      expression.dimension.radian = wanted.radian;
    }
  }

  // ---- ranges: each pass narrows further along chains; endless loops are cut off, which is safe

  void infer_ranges() {
    constexpr int kPasses = 16;
    const auto narrow = [this](FlatSignal& s, int id) {
      const auto before = s.range;
      if (s.kind == SignalKind::Expression) s.range = expression_range(s, id);
      if (s.kind == SignalKind::NodeOutput) s.range = output_range(node_of(s), s.port);
      return s.range.low != before.low || s.range.high != before.high;
    };
    repeat(narrow, kPasses);
  }

  /// What is outside the range of a part was reported there, and raises no second error inside.
  Interval expression_range(const FlatSignal& s, int id) const {
    const auto found = range_of(graph_, s.expression);
    const auto given = part_ranges_.find(id);
    return given != part_ranges_.end() && given->second->excludes(found) ? given->second->range : found;
  }

  Interval output_range(const FlatNode& node, int port) const {
    const auto& type = *node.type;
    if (!type.range) return type.outputs[index(port)].range;
    auto setup = setup_of(node, {});
    for (std::size_t i = 0; i < node.inputs.size(); ++i)
      setup.inputs.push_back({input_range(graph_, node, i), std::nullopt, node.inputs[i].has_value()});
    return type.range(port, setup);
  }

  FlatGraph& graph_;
  std::vector<int> order_;
  std::unordered_map<int, const PartRange*> part_ranges_;  ///< by signal
};

}  // namespace

void infer(FlatGraph& graph, const std::vector<PartRange>& part_ranges, ErrorList& errors) {
  Inference{graph, part_ranges}.run();
  check_facts(graph, part_ranges, errors);
}

}  // namespace tactus
