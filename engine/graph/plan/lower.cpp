#include <algorithm>
#include <cmath>
#include <map>

#include "engine/graph/plan/inserted_nodes.h"
#include "engine/graph/plan/vertex_graph.h"
#include "engine/graph/semantics/facts.h"
#include "engine/graph/semantics/operators.h"

namespace tactus {
namespace {

class Lowering {
  using Kind = Vertex::Kind;
  using Op = Expression::Op;
  using SignalKind = FlatSignal::Kind;

 public:
  explicit Lowering(const FlatGraph& flat) : flat_(flat) {}

  VertexGraph run() {
    graph_.vertices.reserve(flat_.signals.size());
    for (std::size_t i = 0; i < flat_.signals.size(); ++i) {
      const auto& signal = flat_.signals[i];
      wires_.emplace_back(index(signal.lanes));
      if (signal.kind == SignalKind::NodeOutput) continue;
      for (int lane = 0; lane < signal.lanes; ++lane)
        wires_[i][index(lane)] =
            signal.kind == SignalKind::SystemDelay ? system_delay(signal) : make_source(signal, lane);
    }
    make_nodes();
    // All names have their vertices now; loops can be closed.
    for (std::size_t i = 0; i < flat_.signals.size(); ++i) {
      const auto& signal = flat_.signals[i];
      if (signal.kind != SignalKind::Expression) continue;
      divisor_ = signal.conversion ? signal.conversion->from : signal.divisor;
      for (int lane = 0; lane < signal.lanes; ++lane) {
        const auto wire = lower(signal.expression, lane, signal.lanes, signal.path);
        graph_.vertices[index(wires_[i][index(lane)].vertex)].in = {wire};
      }
    }
    connect_nodes();
    make_outputs();
    return std::move(graph_);
  }

 private:
  static std::string lane_path(const std::string& path, int lane, int lanes) {
    return lanes > 1 ? path + "[" + std::to_string(lane) + "]" : path;
  }

  Wire add(Vertex vertex) {
    graph_.vertices.push_back(std::move(vertex));
    return {static_cast<int>(graph_.vertices.size()) - 1, 0};
  }

  Wire constant(double value, const Source& at = {}) { return add({.value = value, .at = at}); }

  /// What is made of the same thing lane after lane belongs together; the second time round is another thing.
  void set_lane(Vertex& vertex, const void* of, int lane, int lanes) {
    vertex.lane = lane;
    vertex.lanes = lanes;
    if (lanes < 2) return;
    const int origin = origins_.try_emplace(of, static_cast<int>(origins_.size())).first->second;
    vertex.origin = {origin, made_of_[{origin, lane}]++};
  }

  Wire make_source(const FlatSignal& signal, int lane) {
    // As FlatSignal::Kind; a missing signal is a constant that nothing reads.
    static constexpr Kind kKinds[] = {Kind::Constant, Kind::Input,     Kind::Control,  Kind::SystemDelay,
                                      Kind::Constant, Kind::Operation, Kind::Operation};
    Vertex vertex{.kind = kKinds[static_cast<int>(signal.kind)],
                  .divisor = signal.divisor,
                  .path = lane_path(signal.path, lane, signal.lanes),
                  .at = signal.at};
    set_lane(vertex, &signal, lane, signal.lanes);
    if (signal.kind == SignalKind::SystemRate) vertex.value = signal.range.low;
    if (vertex.kind == Kind::Input) {
      vertex.index = static_cast<int>(graph_.input_names.size());
      graph_.input_names.push_back(vertex.path);
    }
    if (vertex.kind == Kind::Control) vertex.index = signal.index;
    if (vertex.kind == Kind::Operation) vertex.op = Op::Signal;
    if (signal.conversion) make_rate_converter(vertex, signal);
    return add(std::move(vertex));
  }

  /// One for all files.
  Wire system_delay(const FlatSignal& signal) {
    if (system_delay_.vertex < 0) system_delay_ = make_source(signal, 0);
    return system_delay_;
  }

  void make_rate_converter(Vertex& vertex, const FlatSignal& signal) const {
    vertex.kind = Kind::RateConverter;
    vertex.conversion = *signal.conversion;
    vertex.origin = {};
    if (is_trigger(signal.expression, 0)) vertex.conversion.how = RateConversion::How::Trigger;
  }

  /// A name for what a node fires, through as many files as there may be.
  bool is_trigger(const Expression& expression, int depth) const {
    if (expression.op == Op::Pick) return is_trigger(expression.arguments.front(), depth);
    if (expression.op != Op::Signal || depth > 64) return false;
    const auto& signal = flat_.signals[index(expression.signal)];
    if (signal.kind == SignalKind::Expression) return is_trigger(signal.expression, depth + 1);
    if (signal.kind != SignalKind::NodeOutput) return false;
    const auto& type = *flat_.nodes[index(signal.index)].type;
    return type.outputs[index(signal.port)].kind == OutputKind::Trigger;
  }

  void make_nodes() {
    for (std::size_t n = 0; n < flat_.nodes.size(); ++n) {
      const auto& node = flat_.nodes[n];
      first_vertex_.push_back(static_cast<int>(graph_.vertices.size()));
      if (node.type->reduces_lanes) {  // a sum of lanes: plain additions
        const int output = node.outputs.front();
        wires_[index(output)][0] = make_source(flat_.signals[index(output)], 0);
        continue;
      }
      for (int lane = 0; lane < node.lanes; ++lane) {
        Vertex vertex{.kind = Kind::Node,
                      .index = static_cast<int>(n),
                      .divisor = node.divisor,
                      .outputs = static_cast<int>(node.outputs.size()),
                      .path = lane_path(node.path, lane, node.lanes),
                      .at = node.at,
                      .type = node.type,
                      .turns = turns(node)};
        set_lane(vertex, &node, lane, node.lanes);
        const auto wire = add(std::move(vertex));
        for (std::size_t port = 0; port < node.outputs.size(); ++port)
          wires_[index(node.outputs[port])][index(lane)] = {wire.vertex, static_cast<int>(port)};
      }
    }
  }

  void connect_nodes() {
    for (std::size_t n = 0; n < flat_.nodes.size(); ++n) {
      const auto& node = flat_.nodes[n];
      divisor_ = node.divisor;
      if (node.type->reduces_lanes) {
        connect_mix(node);
        continue;
      }
      for (int lane = 0; lane < node.lanes; ++lane) {
        std::vector<Wire> in;
        for (std::size_t i = 0; i < node.inputs.size(); ++i)
          in.push_back(node.inputs[i] ? lower(*node.inputs[i], lane, node.lanes, node.path)
                                      : constant(node.type->inputs[i].fallback.value_or(0)));
        const auto v = first_vertex_[n] + lane;
        if (!node.compensate.empty()) compensate(node, lane, in);
        graph_.vertices[index(v)].in = std::move(in);
      }
    }
  }

  /// A time less the phase delays of other nodes, or with them: a vertex for each, that reads all inputs of
  /// that node, since those decide what the delay is.
  void compensate(const FlatNode& node, int lane, std::vector<Wire>& in) {
    const auto& where = *node.type->compensation;
    const auto time = index(where.port), period = index(where.period);
    for (const int other_index : node.compensate) {
      const auto& other = flat_.nodes[index(other_index)];
      // It reads what the compensations before this one left, then the period, then the parameters.
      Vertex vertex{.kind = Kind::PhaseDelay,
                    .value = where.sign,
                    .index = first_vertex_[index(other_index)] + std::min(lane, other.lanes - 1),
                    .divisor = node.divisor,
                    .in = {in[time], lower(*node.inputs[period], lane, node.lanes, node.path)},
                    .path = lane_path(node.path, lane, node.lanes) + ".compensate",
                    .at = node.at};
      for (std::size_t i = 0; i < other.inputs.size(); ++i)
        vertex.in.push_back(other.type->inputs[i].late || i == 0 || !other.inputs[i]
                                ? constant(other.type->inputs[i].fallback.value_or(0))
                                : lower(*other.inputs[i], lane, node.lanes, node.path));
      in[time] = add(std::move(vertex));
    }
  }

  void connect_mix(const FlatNode& node) {
    Vertex sum{.kind = Kind::Sum, .divisor = node.divisor, .path = node.path, .at = node.at};
    for (int lane = 0; lane < node.lanes; ++lane)
      sum.in.push_back(lower(*node.inputs.front(), lane, node.lanes, node.path));
    const auto wire = node.lanes == 1 ? sum.in[0] : add(std::move(sum));
    const auto out = wires_[index(node.outputs.front())][0];
    graph_.vertices[index(out.vertex)].in = {wire};
  }

  Wire lower(const Expression& expression, int lane, int lanes, const std::string& path) {
    if (lanes == 1 || lanes_of(flat_, expression) != 1) return lower_lane(expression, lane, lanes, path);
    const auto [known, fresh] = shared_.try_emplace(&expression);
    if (fresh) known->second = lower_lane(expression, 0, 1, path);
    return known->second;
  }

  Wire lower_lane(const Expression& expression, int lane, int lanes, const std::string& path) {
    switch (expression.op) {
      case Op::Number:
        return constant(expression.number, expression.at);
      case Op::Signal: {
        const auto& wires = wires_[index(expression.signal)];
        return wires[wires.size() == 1 ? 0 : index(lane)];
      }
      case Op::Lanes: {
        const auto& own = expression.arguments[expression.arguments.size() == 1 ? 0 : index(lane)];
        return own.op == Op::Number ? own_number(own.number, expression, lane, lanes)
                                    : lower(own, 0, 1, path);
      }
      case Op::Pick: {
        const auto& signal = expression.arguments.front();
        const int picked = expression.lanes[expression.lanes.size() == 1 ? 0 : index(lane)];
        return lower_lane(signal, picked, lanes_of(flat_, signal), path);
      }
      case Op::Spread:
        return own_number(spread(expression, lane, lanes), expression, lane, lanes);
      default:
        break;
    }
    std::vector<Wire> in;
    for (const auto& argument : expression.arguments) in.push_back(lower(argument, lane, lanes, path));
    Vertex vertex{.kind = Kind::Operation, .divisor = divisor_, .path = path, .at = expression.at};
    const auto add_operator = [&](Op op, std::vector<Wire> operands) {
      vertex.op = op;
      vertex.in = std::move(operands);
      set_lane(vertex, &expression, lane, lanes);
      return add(vertex);
    };
    if (const auto* definition = definition_of(expression.op))
      return lower_definition(*definition, in, add_operator);
    return add_operator(expression.op, std::move(in));
  }

  /// The names in a definition are a, b and c: the wires in `in`.
  template <class Add>
  Wire lower_definition(const Expression& expression, const std::vector<Wire>& in, const Add& add_operator) {
    if (expression.op == Op::Signal) return in[index(expression.name.front() - 'a')];
    std::vector<Wire> operands;
    for (const auto& argument : expression.arguments)
      operands.push_back(lower_definition(argument, in, add_operator));
    return add_operator(expression.op, std::move(operands));
  }

  /// Of a list or a spread: its lanes stay together even where one of them is 0 or 1.
  Wire own_number(double value, const Expression& expression, int lane, int lanes) {
    const auto wire = constant(value, expression.at);
    set_lane(graph_.vertices.back(), &expression, lane, lanes);
    return wire;
  }

  static double spread(const Expression& expression, int lane, int lanes) {
    const double from = expression.arguments[0].number;
    const double to = expression.arguments[1].number;
    const double position = lanes > 1 ? static_cast<double>(lane) / (lanes - 1) : 0;
    return expression.exponential ? from * std::pow(to / from, position) : from + (to - from) * position;
  }

  void make_outputs() {
    divisor_ = 1;
    for (const auto& output : flat_.outputs) {
      for (int lane = 0; lane < output.lanes; ++lane) {
        Vertex vertex{.kind = Kind::Output,
                      .index = static_cast<int>(graph_.channels.size()),
                      .in = {lower(output.expression, lane, output.lanes, output.name)},
                      .outputs = 0,
                      .path = lane_path(output.name, lane, output.lanes),
                      .at = output.at};
        graph_.channels.push_back({vertex.path, output.use, output.dimension});
        add(std::move(vertex));
      }
    }
  }

  const FlatGraph& flat_;
  VertexGraph graph_;
  int divisor_ = 1;                       ///< of the expression that is being lowered
  std::vector<std::vector<Wire>> wires_;  ///< [signal][lane]
  Wire system_delay_;
  std::vector<int> first_vertex_;               ///< [node]
  std::map<const Expression*, Wire> shared_;    ///< what all lanes have in common
  std::map<const void*, int> origins_;          ///< numbers of signals, nodes and expressions with lanes
  std::map<std::pair<int, int>, int> made_of_;  ///< [origin, lane]: how many vertices
};

}  // namespace

VertexGraph lower(const FlatGraph& flat) { return Lowering{flat}.run(); }

}  // namespace tactus
