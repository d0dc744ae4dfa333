#include <algorithm>
#include <functional>
#include <optional>

#include "engine/graph/plan/compile.h"
#include "engine/graph/plan/fingerprint.h"
#include "engine/graph/plan/inserted_nodes.h"
#include "engine/graph/semantics/facts.h"
#include "engine/graph/semantics/operators.h"

namespace tactus {
namespace {

void add(Fingerprint& print, const SettingValue& setting) {
  print.add(setting.text).add(setting.number).add(std::uint64_t{setting.given});
  print.add(std::uint64_t{setting.points.size()});
  for (const auto& [x, y] : setting.points) print.add(x).add(y);
  print.add(std::uint64_t{setting.numbers.size()});
  for (const double number : setting.numbers) print.add(number);
  print.add(std::uint64_t{setting.names.size()});
  for (const auto& name : setting.names) print.add(name);
}

/// Of everything that a node was made from: two nodes with the same fingerprint differ in their state alone.
/// Of an input counts what `make` asked for, or what it always gets because the port is fixed.
std::uint64_t fingerprint(const NodeSetup& setup) {
  Fingerprint print;
  print.add(setup.type->name).add(setup.type->fingerprint).add(setup.sample_rate.value);
  print.add(static_cast<std::uint64_t>(setup.lane)).add(setup.variant);
  for (const auto& setting : setup.settings) add(print, setting);
  for (std::size_t i = 0; i < setup.inputs.size(); ++i) {
    const auto& input = setup.inputs[i];
    if (!setup.type->inputs[i].fixed && !input.asked) continue;
    print.add(std::uint64_t{i}).add(input.range.low).add(input.range.high);
    print.add(std::uint64_t{input.constant.has_value()}).add(input.constant.value_or(0));
    print.add(std::uint64_t{input.connected});
  }
  return print.value();
}

class Maker {
  using Kind = Vertex::Kind;

 public:
  Maker(VertexGraph& graph, const FlatGraph& flat, const CompileOptions& options, ErrorList& errors)
      : graph_(graph),
        flat_(flat),
        options_(options),
        errors_(errors),
        memory_(options.most_bytes),
        frozen_controls_(flat.controls.size(), false) {
    for (const auto& vertex : graph.vertices) read_outputs_.emplace_back(index(vertex.outputs));
    for (const auto& vertex : graph.vertices)
      for (const auto& wire : vertex.in) read_outputs_[index(wire.vertex)][index(wire.port)] = true;
  }

  std::vector<bool> run() {
    // Nodes that others are compensated for come first: their response bounds the delay of those.
    for (const bool compensated : {false, true}) {
      if (compensated) fold_phase_delays();
      for (auto& vertex : graph_.vertices)
        if (vertex.kind == Kind::Node && flat_node(vertex).compensate.empty() != compensated) make(vertex);
    }
    for (auto& vertex : graph_.vertices) {
      if (vertex.kind == Kind::RateConverter) make_rate_converter(vertex);
      if (vertex.kind != Kind::PhaseDelay) continue;
      const auto& other = compensated(vertex);
      vertex.fingerprint = other.fingerprint;
      if (other.node != nullptr)
        vertex.node = std::make_shared<PhaseDelay>(other.node, static_cast<int>(vertex.in.size()) - 2,
                                                   rate_of(vertex.divisor), vertex.value);
      else if (!errors_.any())
        report_phase(vertex);
    }
    return std::move(frozen_controls_);
  }

 private:
  const FlatNode& flat_node(const Vertex& vertex) const { return flat_.nodes[index(vertex.index)]; }
  const Vertex& compensated(const Vertex& phase_delay) const {
    return graph_.vertices[index(phase_delay.index)];
  }
  const Vertex& at(Wire wire) const { return graph_.vertices[index(wire.vertex)]; }

  Hertz rate_of(int divisor) const { return Hertz{options_.sample_rate.value / divisor}; }

  void make_rate_converter(Vertex& vertex) {
    const auto& how = vertex.conversion;
    vertex.node =
        std::make_shared<RateConverter>(how, vertex.divisor, rate_of(std::min(how.from, vertex.divisor)));
    Fingerprint print;
    for (const int number : {how.from, vertex.divisor, static_cast<int>(how.how)})
      print.add(static_cast<std::uint64_t>(number));
    vertex.fingerprint = print.value();
  }

  void make(Vertex& vertex) {
    const auto& node = flat_node(vertex);
    auto setup = setup_with_inputs(node, vertex);
    if (!setup || (!node.compensate.empty() && !shorten_time(node, vertex, *setup))) return;
    auto made = make_within(*setup);
    if (made) {
      vertex.node = std::move(*made);
      vertex.fingerprint = fingerprint(*setup);
      for (const auto& left : vertex.node->left_out())
        graph_.left_out.push_back({vertex.path + "." + left.path, left.reason});
      return;
    }
    auto error = made.error().where.empty() ? made.error().at(node.at.text()) : made.error();
    // As the file at that place calls it, so that the error of a part used twice is reported once.
    error.what = node.label() + ": " + error.what;
    errors_.add(std::move(error));
  }

  /// Each lane of each node keeps the numbers of its settings, besides its state.
  Result<std::unique_ptr<Node>> make_within(NodeSetup& setup) {
    setup.memory = &memory_;
    std::size_t numbers = 0;
    for (const auto& setting : setup.settings) numbers += setting.numbers.size() + 2 * setting.points.size();
    if (const auto fits = setup.take_memory(numbers); !fits) return tl::unexpected(fits.error());
    return setup.type->make(setup);
  }

  /// A phase delay that never changes leaves a delay time that rests.
  void fold_phase_delays() {
    for (auto& vertex : graph_.vertices) {
      if (vertex.kind != Kind::PhaseDelay) continue;
      const auto& other = compensated(vertex).node;
      std::vector<double> in;
      for (const auto& wire : vertex.in)
        if (at(wire).kind == Kind::Constant) in.push_back(at(wire).value);
      if (other == nullptr || in.size() != vertex.in.size()) continue;
      const auto taken = PhaseDelay::at(other, in[1], {in.begin() + 2, in.end()}, rate_of(vertex.divisor));
      if (!taken) continue;
      vertex.kind = Kind::Constant;
      vertex.value = in[0] + vertex.value * *taken;
      vertex.in.clear();
    }
  }

  /// Nothing after an error.
  std::optional<NodeSetup> setup_with_inputs(const FlatNode& node, const Vertex& vertex) {
    auto setup = setup_of(node, options_.sample_rate, vertex.lane);
    setup.read = read_outputs_[&vertex - graph_.vertices.data()];
    bool right = true;
    for (std::size_t i = 0; i < vertex.in.size(); ++i) {
      InputInfo info{node.ranges[i], std::nullopt, node.inputs[i].has_value()};
      const auto& source = at(vertex.in[i]);
      if (source.kind == Kind::Constant) info.constant = source.value;
      if (node.type->inputs[i].fixed) {
        info.constant = starting_value(vertex.in[i], 0);
        right = right && info.constant.has_value();
        if (!info.constant)
          errors_.add(Errc::WrongType, node.inputs[i]->at,
                      "'" + node.type->inputs[i].name + "' of " + node.type->name + " '" + node.path +
                          "' must not change during playback",
                      "give a number, a quantity, or an expression of controls");
      }
      if (info.constant) info.range = Interval::exactly(*info.constant);
      setup.inputs.push_back(info);
    }
    return right ? std::optional{std::move(setup)} : std::nullopt;
  }

  /// What a signal is when the graph starts, if only constants and controls decide it. Such controls freeze.
  std::optional<double> starting_value(Wire wire, int depth) {
    const auto& vertex = at(wire);
    if (vertex.kind == Kind::Constant) return vertex.value;
    if (vertex.kind == Kind::SystemDelay) return options_.system_delay.value;
    if (vertex.kind == Kind::Control) {
      frozen_controls_[index(vertex.index)] = true;
      return flat_.controls[index(vertex.index)].value;
    }
    if (vertex.kind == Kind::Sum) return starting_sum(vertex, depth);
    if (vertex.kind == Kind::RateConverter) return starting_value(vertex.in[0], depth + 1);
    if (vertex.kind != Kind::Operation || depth > 1000) return std::nullopt;
    OperandValues operands{};
    for (std::size_t i = 0; i < vertex.in.size(); ++i) {
      const auto value = starting_value(vertex.in[i], depth + 1);
      if (!value) return std::nullopt;
      operands[i] = *value;
    }
    return evaluate(vertex.op, operands[0], operands[1], operands[2]);
  }

  std::optional<double> starting_sum(const Vertex& sum, int depth) {
    std::vector<double> values;
    for (const auto& wire : sum.in) {
      const auto value = depth > 1000 ? std::nullopt : starting_value(wire, depth + 1);
      if (!value) return std::nullopt;
      values.push_back(*value);
    }
    return add_lanes(values, std::plus<>{});
  }

  /// False if a node that is compensated for could not be made: nothing is known of its delay.
  bool shorten_time(const FlatNode& node, const Vertex& vertex, NodeSetup& setup) {
    const auto& where = *node.type->compensation;
    const auto time = index(where.port);
    auto tuned = node.ranges[index(where.period)];
    if (!tuned.bounded()) return true;  // the node itself asks for bounds
    // No period is shorter than two frames.
    const double shortest = 2 / rate_of(node.divisor).value;
    tuned = {std::max(tuned.low, shortest), std::max(tuned.high, shortest)};
    Wire wire = vertex.in[time];
    Interval left{0, 0};
    for (; at(wire).kind == Kind::PhaseDelay; wire = at(wire).in[0]) {
      const auto& other = compensated(at(wire));
      if (other.node == nullptr) return false;
      const auto taken = PhaseDelay::range(other.node, tuned, flat_node(other).ranges, rate_of(node.divisor));
      if (!taken) return report_phase(at(wire)), false;
      left = left + (where.sign < 0 ? Interval{-taken->high, -taken->low} : *taken);
    }
    left = left + (at(wire).kind == Kind::Constant ? Interval::exactly(at(wire).value) : node.ranges[time]);
    if (wire == vertex.in[time] && left.single()) return true;
    setup.inputs[time].constant.reset();
    setup.inputs[time].range = {std::max(0.0, left.low), std::max(0.0, left.high)};
    return true;
  }

  void report_phase(const Vertex& phase_delay) {
    errors_.add(
        Errc::BadArgument, phase_delay.at,
        "the phase delay of '" + compensated(phase_delay).path + "' cannot be compensated: it is not known",
        "list filters in the same loop");
  }

  VertexGraph& graph_;
  const FlatGraph& flat_;
  const CompileOptions& options_;
  ErrorList& errors_;
  MemoryBudget memory_;
  std::vector<bool> frozen_controls_;
  std::vector<std::vector<bool>> read_outputs_;  ///< of each vertex
};

}  // namespace

std::vector<bool> make_nodes(VertexGraph& graph, const FlatGraph& flat, const CompileOptions& options,
                             ErrorList& errors) {
  return Maker{graph, flat, options, errors}.run();
}

}  // namespace tactus
