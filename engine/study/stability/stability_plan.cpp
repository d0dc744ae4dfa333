#include <algorithm>
#include <cmath>
#include <map>
#include <ranges>
#include <set>
#include <utility>

#include "engine/core/index.h"
#include "engine/graph/plan/plan.h"
#include "engine/study/stability/models/stability_graph.h"

namespace tactus {
namespace {

/// Any z serves to ask whether there is a response at all.
const std::complex<double> kSomewhere = std::polar(1.0, 0.01);
/// What has the same real response at these is no function of z: a node without memory.
const std::complex<double> kElsewhere[] = {std::polar(1.0, 1.0), std::polar(1.1, 2.3)};

class PlanReader {
 public:
  PlanReader(LinearGraph& graph, const Plan& plan, const SamplingClocks& clocks, const Regime& regime,
             std::string prefix)
      : graph_(graph), plan_(plan), clocks_(clocks), regime_(regime), prefix_(std::move(prefix)) {}

  Terminals run() {
    Terminals terminals;
    places_.resize(plan_.vertices.size());
    std::vector<int> input_vertex(plan_.input_names.size(), -1);
    for (int v = 0; v < static_cast<int>(plan_.vertices.size()); ++v)
      if (vertex(v).kind == Vertex::Kind::Input) input_vertex[index(vertex(v).index)] = v;
    for (std::size_t i = 0; i < input_vertex.size(); ++i)
      terminals.inputs.push_back(input_vertex[i] < 0 ? -1 : made(input_vertex[i], 0, plan_.input_names[i]));
    find_independent();
    for (const bool join : {false, true})
      for (const auto& step : plan_.steps)
        if (step.kind == Step::Kind::Operations)
          join ? join_operations(step) : make_operations(step);
        else if (has_outputs(step) && !(join && independent_[index(step.vertex)]))
          join ? join_node(step) : make_outputs(step);
    for (const auto& channel : plan_.channels) terminals.channels.push_back(signal(channel.from));
    return terminals;
  }

 private:
  static bool has_outputs(const Step& step) {
    return step.kind == Step::Kind::Process || step.kind == Step::Kind::Emit;
  }
  const Vertex& vertex(int v) const { return plan_.vertices[index(v)]; }
  bool is_network(int node) const {
    return dynamic_cast<const NetworkView*>(plan_.nodes[index(node)].get()) != nullptr;
  }
  bool is_network(const Step& step) const { return is_network(step.node); }

  /// What depends on no input, no network and no loop takes its course whatever happens, as the envelope of
  /// an effect: it lies on no loop.
  void find_independent() {
    const auto follows = [&](const Vertex& vertex) {
      return vertex.kind != Vertex::Kind::Input && !(vertex.runs >= 0 && is_network(vertex.runs)) &&
             std::ranges::all_of(vertex.in,
                                 [&](const Wire& wire) { return independent_[index(wire.vertex)]; });
    };
    independent_.assign(plan_.vertices.size(), false);
    for (bool more = true; std::exchange(more, false);)
      for (std::size_t v = 0; v < independent_.size(); ++v)
        if (!independent_[v] && follows(plan_.vertices[v])) independent_[v] = more = true;
  }
  std::string path_of(int v) const { return prefix_ + vertex(v).path; }

  int made(int v, int port, const std::string& name, int divisor = 1) {
    auto& ports = places_[index(v)];
    if (ports.empty()) ports.assign(index(vertex(v).outputs), -1);
    return ports[index(port)] = graph_.add_signal(prefix_ + name, divisor);
  }
  /// -1: a constant, a control, or a function of these alone.
  int signal(int v, int port) const {
    const auto& ports = places_[index(v)];
    return ports.empty() ? -1 : ports[index(port)];
  }
  int signal(const Wire& wire) const { return signal(wire.vertex, wire.port); }
  /// The wire of an operand; unary operations have two equal operands.
  const Wire& operand(int v, int k) const {
    const auto& in = vertex(v).in;
    return in[std::min(index(k), in.size() - 1)];
  }
  PlanSignal source(const Wire& wire) const { return {&plan_, wire.vertex, wire.port}; }
  bool is_read(const Step& step, int output) const {
    return plan_.outputs[index(step.first_out + output)] != nullptr;
  }
  int divisor(const Step& step) const { return plan_.divisors[index(step.divider)]; }
  int divisor_out(const Step& step) const { return plan_.divisors[index(step.divider_out)]; }
  double value(int slot) const { return *plan_.inputs[index(slot)].data; }

  void make_outputs(const Step& step) {
    // A constant crosses the border of a part with its own rate as a number.
    const bool crosses = step.divider_in != step.divider_out;
    const auto& from = vertex(step.vertex);
    if (crosses && signal(from.in.front()) < 0) return;
    for (int i = 0; from.type != nullptr && i < step.inputs; ++i)
      if (from.type->inputs[index(i)].hold && value(step.first_in + i) > 0) held_apart_.insert(step.vertex);
    for (int o = 0; o < step.outputs; ++o) {
      if (!is_read(step, o)) continue;
      std::string name = from.path;
      if (from.type != nullptr && o > 0) name += "." + from.type->outputs[index(o)].name;
      const int signal = made(step.vertex, o, name, divisor_out(step));
      if (is_network(step) && name.ends_with(".wave")) graph_.wave_ports.push_back(signal);
    }
  }

  /// Functions of controls alone are constants.
  void make_operations(const Step& step) {
    for (int i = step.first_operation; i < step.first_operation + step.operations; ++i) {
      const auto& operation = plan_.operations[index(i)];
      const auto* in = plan_.inputs.data() + operation.first_in;
      const bool rests = operation.can_rest >= 0 ||
                         std::all_of(in, in + operation.operands, [](const auto& s) { return s.constant(); });
      if (rests) continue;
      const int v = operation.vertex;
      made(v, 0, vertex(v).path, divisor(step));
      std::array<PlanSignal, kMostOperands> sources;
      for (int k = 0; k < operation.operands; ++k) sources[index(k)] = source(operand(v, k));
      const auto operands = operands_of_vertex(operation);
      derived_.note({&plan_, v, 0}, operator_of(operation.op), sources, operands);
      note_limit(operation, operands);
    }
  }

  /// A minimum or maximum with one operand that does not move.
  void note_limit(const MicroOperation& operation, const Operands& operands) {
    if (!is_limit(operation, operands)) return;
    const double limit = operands.at[operands.moves[0] ? 1 : 0];
    (operation.op == Expression::Op::Min ? highest_ : lowest_)[operation.vertex] = limit;
  }
  static bool is_limit(const MicroOperation& operation, const Operands& operands) {
    return (operation.op == Expression::Op::Min || operation.op == Expression::Op::Max) &&
           operands.moving() == 1;
  }

  /// Whether nothing that moves passes: a product with a constant 0, and a clamp between two equal values.
  bool is_idle(const MicroOperation& operation, const Operands& operands) const {
    if (operands.moving() != 1) return false;
    const int moving = static_cast<int>(std::ranges::find(operands.moves, true) - operands.moves.begin());
    const double fixed = operands.at[moving == 0 ? 1 : 0];
    if (operator_of(operation.op).small_signal == SmallSignal::Product) return fixed == 0;
    if (!is_limit(operation, operands)) return false;
    const int from = operand(operation.vertex, moving).vertex;
    const bool least = operation.op == Expression::Op::Min;
    const auto& limits = least ? lowest_ : highest_;
    const auto limit = limits.find(from);
    return limit != limits.end() && (least ? limit->second >= fixed : limit->second <= fixed);
  }

  void join_operations(const Step& step) {
    for (int i = step.first_operation; i < step.first_operation + step.operations; ++i) {
      const auto& operation = plan_.operations[index(i)];
      if (signal(operation.vertex, 0) < 0 || independent_[index(operation.vertex)]) continue;
      const auto operands = operands_of_vertex(operation);
      if (is_idle(operation, operands)) continue;
      note_laws(operation, operands);
      for (int k = 0; k < operation.operands; ++k)
        if (operands.moves[index(k)]) join_operand(operation, operands, k);
    }
  }

  /// What makes the gains of an operation depend on signals.
  void note_laws(const MicroOperation& operation, const Operands& operands) {
    const auto& type = operator_of(operation.op);
    const auto path = path_of(operation.vertex);
    const PlanSignal out{&plan_, operation.vertex, 0};
    const auto from = [&](int k) { return derived_.of(source(operand(operation.vertex, k))); };
    const auto note = [&](Nonlinearity law) {
      law.signal = signal(operation.vertex, 0);
      graph_.laws.push_back(std::move(law));
      // Flatter behind it, where it is taken off something it makes that steeper.
      graph_.has_touched = true;
    };
    for (int k = 0; k < operation.operands; ++k)
      if (operands.moves[index(k)])
        if (auto law = corner(path, type, operands, k, from(k))) note(std::move(*law));
    const int moving = operands.moving();
    if (type.small_signal == SmallSignal::Corner && moving == 2)
      note(corner_of_two(path, out, type, operands, {from(0), from(1)}));
    if (type.small_signal == SmallSignal::Bounded) note(curve(path, type, operands, from(0)));
    if (type.small_signal == SmallSignal::Choice && operands.moves[0]) note(choice(path, out, operands));
    graph_.varies |= type.small_signal == SmallSignal::Product && moving == 2;
    graph_.varies |= type.small_signal == SmallSignal::Quotient && operands.moves[1];
    graph_.varies |= type.small_signal == SmallSignal::Curved;
  }

  void join_operand(const MicroOperation& operation, const Operands& operands, int k) {
    const auto& type = operator_of(operation.op);
    const LinearEdge edge{.from = signal(operand(operation.vertex, k)),
                          .to = signal(operation.vertex, 0),
                          .path = path_of(operation.vertex)};
    const auto rest = slope_of(type, operands, k, false);
    const auto steep = slope_of(type, operands, k, true);
    graph_.has_touched |= steep != rest;
    graph_.nonlinear |= steep != rest;
    const auto gain = regime_.touched ? touched_slope(operation, k) : rest;
    if (!gain) return add_step(edge, type);
    if (*gain == 0 && !regime_.all_paths) return;
    graph_.edges.push_back(edge);
    graph_.edges.back().gain = *gain;
  }

  /// An operator that steps, or one whose slope is not finite here.
  void add_step(LinearEdge edge, const Operator& type) {
    edge.kind = LinearEdge::Kind::Event;
    add_event({edge.path, std::string{"operator "} + type.name, {}});
    graph_.edges.push_back(std::move(edge));
  }

  Operands operands_of_vertex(const MicroOperation& operation) const {
    Operands operands;
    for (int k = 0; k < operation.operands; ++k) {
      operands.at[index(k)] = value(operation.first_in + k);
      operands.moves[index(k)] = signal(operand(operation.vertex, k)) >= 0;
    }
    return operands;
  }

  std::optional<double> touched_slope(const MicroOperation& operation, int which) const {
    const auto& type = operator_of(operation.op);
    auto operands = operands_of_vertex(operation);
    if (const auto choice = regime_.moved.find(choice_at({&plan_, operation.vertex, 0}));
        choice != regime_.moved.end() && slope_of(type, operands, which, true))
      return choice->second == which ? 1 : 0;
    bool taken = false;
    for (int k = 0; k < operation.operands; ++k)
      if (const auto by = derived_.moved(source(operand(operation.vertex, k)), regime_.moved))
        operands.at[index(k)] += *by, taken = true;
    return slope_of(type, operands, which, !taken);
  }

  void join_node(const Step& step) {
    if (is_network(step)) return join_network(step);
    const auto& from = vertex(step.vertex);
    const auto* type = from.type.get();
    std::vector<double> at;
    std::vector<bool> moves;
    for (int i = 0; i < step.inputs; ++i) {
      at.push_back(value(step.first_in + i));
      moves.push_back(signal(from.in[index(i)]) >= 0);
    }
    graph_.varies |= std::ranges::count(moves, true) > 1 && (type == nullptr || !type->stateless);
    const bool restores = type != nullptr && type->stateless && move_to_regime(step, at, moves);
    for (int i = 0; i < step.inputs; ++i)
      for (int o = 0; moves[index(i)] && o < step.outputs; ++o)
        if (is_read(step, o)) join_port(step, i, o, at, restores);
  }

  PlanSignal source(const Step& step, std::size_t input) const {
    return source(vertex(step.vertex).in[input]);
  }

  /// Moves `at` to the operating point of the regime. Whether the force restores somewhere, as a spring does.
  bool move_to_regime(const Step& step, std::vector<double>& at, const std::vector<bool>& moves) {
    const auto& node = *plan_.nodes[index(step.node)];
    const auto& type = vertex(step.vertex).type;
    const auto steep = steepest(node, *type, at, moves);
    graph_.has_touched |= steep.at != at;
    for (std::size_t i = 0; i < at.size(); ++i)
      graph_.nonlinear |= steep.nonlinear && moves[i] && is_spring(*type, i, 0);
    if (steep.nonlinear) note_law(step, at, moves, steep);
    if (!regime_.touched) return steep.answer > 0;
    bool taken = false;
    for (std::size_t i = 0; i < at.size(); ++i)
      if (const auto by = derived_.moved(source(step, i), regime_.moved); moves[i] && by)
        at[i] += *by, taken = true;
    if (!taken) at = steep.at;
    return steep.answer > 0;
  }

  void note_law(const Step& step, const std::vector<double>& at, const std::vector<bool>& moves,
                const SteepPlace& steep) {
    const auto input = index(steep.input);
    const auto from = derived_.of(source(step, input));
    std::vector<double> slopes(at.size(), 0.0);
    for (std::size_t i = 0; i < at.size(); ++i)
      if (const auto other = derived_.of(source(step, i)); moves[i] && other.source == from.source)
        slopes[i] = other.slope;
    const auto answer = [node = plan_.nodes[index(step.node)], type = vertex(step.vertex).type, at, moves,
                         slopes](double moved) {
      auto there = at;
      for (std::size_t i = 0; i < there.size(); ++i) there[i] += slopes[i] * moved;
      return answer_at(*node, *type, there, moves);
    };
    const bool spring = std::ranges::any_of(std::views::iota(std::size_t{0}, at.size()), [&](std::size_t i) {
      return moves[i] && is_spring(*vertex(step.vertex).type, i, 0);
    });
    Nonlinearity law{path_of(step.vertex), from.source, (steep.at[input] - at[input]) / from.slope, answer};
    if (!spring) {
      law.slope = [node = plan_.nodes[index(step.node)], at, moves, slopes](double moved) {
        auto there = at;
        for (std::size_t i = 0; i < there.size(); ++i) there[i] += slopes[i] * moved;
        double sum = 0;
        for (std::size_t i = 0; i < there.size(); ++i)
          if (moves[i])
            sum += slopes[i] * node->response(static_cast<int>(i), 0, 1.0, there).value_or(0.0).real();
        return sum;
      };
      std::vector<double> middles{0.0};
      for (std::size_t i = 0; i < at.size(); ++i)
        if (!moves[i]) middles.push_back((at[i] - at[input]) / from.slope);
      law.elsewhere = places_of_slopes(law.slope, law.to, middles);
      graph_.has_touched |= law.elsewhere.size() > 1;
    }
    for (int o = 0; o < step.outputs && law.signal < 0; ++o) law.signal = signal(step.vertex, o);
    graph_.laws.push_back(std::move(law));
  }

  /// `restores`: the force restores at some place, as a spring does.
  void join_port(const Step& step, int input, int output, const std::vector<double>& at, bool restores) {
    const auto& node = plan_.nodes[index(step.node)];
    const auto& from = vertex(step.vertex);
    const auto* type = from.type.get();
    LinearEdge edge{.kind = LinearEdge::Kind::Node,
                    .from = signal(from.in[index(input)]),
                    .to = signal(step.vertex, output),
                    .path = path_of(step.vertex),
                    .frames = std::max(0, node->delay(input, output).most) * divisor(step),
                    .node = node,
                    .input = input,
                    .output = output,
                    .at = at,
                    .divisor = divisor(step)};
    const auto response = node->response(input, output, kSomewhere, at);
    const auto same = [&](const auto& z) { return node->response(input, output, z, at) == response; };
    if (response && response->imag() == 0.0 && std::ranges::all_of(kElsewhere, same))
      edge.constant = response;
    if (!response) {
      if (type != nullptr && input == 0 && sampling_trigger(*type) >= 0)
        return add_sampling(*type, std::move(edge));
      if (type != nullptr && input == 0 && type->small_signal_gain) {
        edge.kind = LinearEdge::Kind::Gain;
        edge.gain = *type->small_signal_gain;
        stay_behind(*type, edge);
      } else {
        edge.kind = LinearEdge::Kind::Event;
        edge.limited = note_event(edge, type, at, from.in[index(input)]);
      }
    } else if (type != nullptr && type->stateless && *response == 0.0) {
      if (!regime_.all_paths) return;
    } else if (type != nullptr && is_spring(*type, index(input), index(output))) {
      if (response->real() > 0 && restores && !regime_.all_paths)
        return graph_.unstable_equilibria.push_back(edge.path);
      return add_stiff(edge, from, -response->real());
    }
    graph_.edges.push_back(std::move(edge));
  }

  /// What has a dead band, or samples now and then, stays behind small motions: at rest its output does not
  /// follow, and where something else is moved neither. It follows where everything moves.
  void stay_behind(const NodeType& type, LinearEdge& edge) {
    if (!type.dead_band) return;
    graph_.has_touched = true;
    if (!regime_.touched || !regime_.moved.empty()) edge.gain = 0;
  }

  /// A signal of its own between position and force, where the stiffness can be scaled.
  void add_stiff(LinearEdge edge, const Vertex& spring, double stiffness) {
    const int between = graph_.add_signal(edge.path, graph_.divisors[index(edge.to)]);
    graph_.stiff.push_back({between, edge.path, spring.type->name, stiffness, spring.turns});
    graph_.join(between, edge.to);
    edge.to = between;
    graph_.edges.push_back(std::move(edge));
  }

  /// A signal of its own for what is sampled, which has a sample once in a clock's period.
  void add_sampling(const NodeType& type, LinearEdge edge) {
    const auto clock = clocks_.find(edge.node.get());
    edge.kind = LinearEdge::Kind::Gain;
    edge.gain = 1;
    if (clock == clocks_.end() || clock->second == 0) {
      graph_.unclocked.emplace_back(edge.from, edge.path);
      stay_behind(type, edge);
      graph_.edges.push_back(std::move(edge));
      return;
    }
    const int frames = clock->second, sampled = graph_.add_signal(edge.path, frames);
    graph_.edges.push_back({.kind = LinearEdge::Kind::Hold,
                            .from = sampled,
                            .to = edge.to,
                            .path = edge.path,
                            .frames = frames});
    edge.to = sampled;
    graph_.edges.push_back(std::move(edge));
  }

  /// Whether its events are kept apart, which come `from` there.
  bool note_event(const LinearEdge& edge, const NodeType* type, const std::vector<double>& at,
                  const Wire& from) {
    EventPlace place{edge.path, type != nullptr ? type->name : "phase delay", {}};
    for (std::size_t i = 0; type != nullptr && i < type->inputs.size(); ++i)
      if (type->inputs[i].hold) place.hold_s = at[i];
    const bool limited = place.hold_s.value_or(0) > 0 || (type != nullptr && comes_apart(from, 0));
    add_event(std::move(place));
    return limited;
  }

  /// A signal that is 0 but in frames which a hold time keeps apart: the output of a node that has one, or
  /// what is made of such alone. A product needs one such factor.
  bool comes_apart(const Wire& wire, int depth) const {
    constexpr int kDeepest = 32;
    if (depth > kDeepest) return false;
    const auto& from = vertex(wire.vertex);
    const auto apart = [&](const Wire& in) { return comes_apart(in, depth + 1); };
    if (from.kind == Vertex::Kind::Constant) return from.value == 0;
    if (from.kind == Vertex::Kind::Node)
      return held_apart_.contains(wire.vertex) ||
             (from.type->passes_triggers && wire.port == 0 && apart(from.in.front()));
    if (from.kind != Vertex::Kind::Operation) return false;
    switch (from.op) {
      case Expression::Op::Multiply:
        return std::ranges::any_of(from.in, apart);
      case Expression::Op::Signal:
      case Expression::Op::Add:
      case Expression::Op::Max:
        return std::ranges::all_of(from.in, apart);
      default:
        return false;
    }
  }

  /// A node and the expression of its input have one path.
  void add_event(EventPlace place) {
    const auto same = [&](const EventPlace& e) { return e.path == place.path && e.type == place.type; };
    if (std::ranges::none_of(graph_.events, same)) graph_.events.push_back(std::move(place));
  }

  void join_network(const Step& step) {
    const auto& node = plan_.nodes[index(step.node)];
    const auto& view = dynamic_cast<const NetworkView&>(*node);
    const auto path = path_of(step.vertex);
    const auto touching = regime_.contacts.find(path);
    const auto model =
        LinearNetwork::make(view, *vertex(step.vertex).type,
                            touching == regime_.contacts.end() ? Touching{} : touching->second, regime_.hand);
    if (model == nullptr) return skip_network(step, path);
    const int number = static_cast<int>(graph_.networks.size());
    graph_.networks.push_back(model);
    graph_.network_paths.push_back(path);
    if (!model->whole()) return skip_network(step, path);
    for (std::size_t s = 0; s < model->recipe.signal_ports.size(); ++s) {
      const int from = signal(vertex(step.vertex).in[index(model->recipe.signal_ports[s])]);
      for (int o = 0; from >= 0 && o < step.outputs; ++o)
        if (is_read(step, o))
          graph_.edges.push_back({.kind = LinearEdge::Kind::Network,
                                  .from = from,
                                  .to = signal(step.vertex, o),
                                  .path = path,
                                  .frames = divisor(step),
                                  .input = static_cast<int>(s),
                                  .output = o,
                                  .network = number,
                                  .divisor = divisor(step)});
    }
  }

  /// From each input to each output with an unknown gain.
  void skip_network(const Step& step, const std::string& path) {
    graph_.skipped.push_back(path);
    for (int i = 0; i < step.inputs; ++i)
      for (int o = 0; o < step.outputs; ++o) {
        const int from = signal(vertex(step.vertex).in[index(i)]);
        if (from >= 0 && is_read(step, o))
          graph_.edges.push_back(
              {.kind = LinearEdge::Kind::Event, .from = from, .to = signal(step.vertex, o), .path = path});
      }
  }

  LinearGraph& graph_;
  const Plan& plan_;
  const SamplingClocks& clocks_;
  const Regime& regime_;
  std::string prefix_;
  std::vector<bool> independent_;           ///< [vertex] see find_independent
  std::set<int> held_apart_;                ///< vertices of nodes with a hold time
  std::vector<std::vector<int>> places_;    ///< [vertex][port] signal of the graph, or -1
  std::map<int, double> highest_, lowest_;  ///< [vertex] of minima, maxima: what they give at most, at least
  AffineMaps derived_;
};

}  // namespace

int sampling_trigger(const NodeType& type) {
  const auto found = std::ranges::find(type.inputs, true, &InputPort::samples);
  return found == type.inputs.end() ? -1 : static_cast<int>(found - type.inputs.begin());
}

Terminals add_plan(LinearGraph& graph, const Plan& plan, const SamplingClocks& clocks, const Regime& regime,
                   const std::string& prefix) {
  return PlanReader{graph, plan, clocks, regime, prefix}.run();
}

}  // namespace tactus
