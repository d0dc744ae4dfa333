#include "engine/study/stability/stability_schedule.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "engine/core/index.h"
#include "engine/study/stability/models/stability_law.h"

namespace tactus {
namespace {

/// Any z serves to ask whether there is a response at all.
const std::complex<double> kSomewhere = std::polar(1.0, 0.01);

class ScheduleReader {
 public:
  ScheduleReader(LinearGraph& graph, const Schedule& schedule, const Regime& regime, std::string prefix)
      : graph_(graph), schedule_(schedule), regime_(regime), prefix_(std::move(prefix)) {}

  Terminals run() {
    Terminals terminals;
    for (std::size_t i = 0; i < schedule_.input_buffers.size(); ++i)
      terminals.inputs.push_back(made(schedule_.input_buffers[i], schedule_.input_names[i]));
    for (const auto& step : schedule_.steps)
      if (step.kind == Step::Kind::Operations)
        make_operations(step);
      else if (gives(step))
        make_outputs(step);
    for (const auto& step : schedule_.steps)
      if (step.kind == Step::Kind::Operations)
        join_operations(step);
      else if (gives(step))
        join_node(step);
    for (const auto& channel : schedule_.channels) terminals.channels.push_back(signal(channel.signal));
    return terminals;
  }

 private:
  static bool gives(const Step& step) {
    return step.kind == Step::Kind::Process || step.kind == Step::Kind::Emit;
  }
  bool is_network(const Step& step) const {
    return dynamic_cast<const NetworkView*>(schedule_.nodes[index(step.node)].get()) != nullptr;
  }
  const std::string& path_of(int path) const { return schedule_.paths[index(path)]; }

  int made(const double* buffer, const std::string& name) {
    if (buffer == nullptr) return -1;
    const auto [place, added] = places_.try_emplace(buffer, -1);
    if (added) place->second = graph_.add_signal(prefix_ + name);
    return place->second;
  }
  /// -1: a number, a control, or what is made of nothing else.
  int signal(const Signal& signal) const {
    const auto found = places_.find(signal.data);
    return found == places_.end() ? -1 : found->second;
  }
  int every(const Step& step) const { return schedule_.paces[index(step.pace)]; }
  double value(int slot) const { return *schedule_.inputs[index(slot)].data; }

  void make_outputs(const Step& step) {
    // What rests goes into a part with a rate of its own, or out of it, as the number that it is.
    const bool crosses = step.pace_in != step.pace_out;
    if (crosses && signal(schedule_.inputs[index(step.first_in)]) < 0) return;
    for (int o = 0; o < step.outputs; ++o) {
      const auto* type = schedule_.types[index(step.node)].get();
      std::string name = path_of(step.path);
      if (type != nullptr && o > 0) name += "." + type->outputs[index(o)].name;
      const int signal = made(schedule_.outputs[index(step.first_out + o)], name);
      if (signal >= 0 && is_network(step) && name.ends_with(".wave")) graph_.joints.push_back(signal);
    }
  }

  /// What is made of controls alone moves only when a person moves them.
  void make_operations(const Step& step) {
    for (int i = step.first_operation; i < step.first_operation + step.operations; ++i) {
      const auto& operation = schedule_.operations[index(i)];
      const auto* in = schedule_.inputs.data() + operation.first_in;
      const bool rests = operation.can_rest >= 0 || (in[0].constant() && in[1].constant());
      if (rests) continue;
      made(operation.out, path_of(operation.path));
      const double* const from[2] = {in[0].data, in[1].data};
      derived_.note(operation.out, operation.op, from, operands_at(operation.first_in));
    }
  }

  void join_operations(const Step& step) {
    for (int i = step.first_operation; i < step.first_operation + step.operations; ++i) {
      const auto& operation = schedule_.operations[index(i)];
      const auto out = places_.find(operation.out);
      if (out == places_.end()) continue;
      const auto operands = operands_at(operation.first_in);
      for (int k = 0; k < operands_of(operation.op); ++k) {
        if (!operands.moves[index(k)]) continue;
        const auto from = derived_.of(schedule_.inputs[index(operation.first_in + k)].data);
        const auto path = prefix_ + path_of(operation.path);
        if (auto bend = corner(path, operation.op, operands, k, from))
          graph_.laws.push_back(std::move(*bend));
        const double rest = slope_of(operation.op, operands, k, false);
        const double steep = slope_of(operation.op, operands, k, true);
        graph_.has_touched |= steep != rest;
        graph_.bends |= steep != rest;
        const double gain = regime_.touched ? touched_slope(operation.op, operation.first_in, k) : rest;
        if (gain != 0)
          graph_.edges.push_back({.from = signal(schedule_.inputs[index(operation.first_in + k)]),
                                  .to = out->second,
                                  .path = path,
                                  .gain = gain});
      }
    }
  }

  Operands operands_at(int first_in) const {
    const auto* in = schedule_.inputs.data() + first_in;
    return {value(first_in), value(first_in + 1), {signal(in[0]) >= 0, signal(in[1]) >= 0}};
  }

  double touched_slope(Term::Op op, int first_in, int which) const {
    auto operands = operands_at(first_in);
    bool taken = false;
    for (int k = 0; k < operands_of(op); ++k)
      if (const auto by = derived_.moved(schedule_.inputs[index(first_in + k)].data, regime_.moved))
        (k == 0 ? operands.a : operands.b) += *by, taken = true;
    return slope_of(op, operands, which, !taken);
  }

  void join_node(const Step& step) {
    if (is_network(step)) return join_network(step);
    const auto* type = schedule_.types[index(step.node)].get();
    std::vector<double> at;
    std::vector<bool> moves;
    for (int i = 0; i < step.inputs; ++i) {
      at.push_back(value(step.first_in + i));
      moves.push_back(signal(schedule_.inputs[index(step.first_in + i)]) >= 0);
    }
    const bool pulls_back = type != nullptr && type->stateless && take_law(step, at, moves);
    for (int i = 0; i < step.inputs; ++i)
      for (int o = 0; moves[index(i)] && o < step.outputs; ++o)
        if (schedule_.outputs[index(step.first_out + o)] != nullptr) join_port(step, i, o, at, pulls_back);
  }

  const double* buffer(const Step& step, std::size_t input) const {
    return schedule_.inputs[index(step.first_in) + input].data;
  }

  /// To where the regime looks at a law. Whether it pulls back at some place, as a spring does.
  bool take_law(const Step& step, std::vector<double>& at, const std::vector<bool>& moves) {
    const auto& node = *schedule_.nodes[index(step.node)];
    const auto& type = schedule_.types[index(step.node)];
    const auto steep = steepest(node, *type, at, moves);
    graph_.has_touched |= steep.at != at;
    for (std::size_t i = 0; i < at.size(); ++i)
      graph_.bends |= steep.bends && moves[i] && is_spring(*type, i, 0);
    if (steep.bends) note_law(step, at, moves, steep);
    if (!regime_.touched) return steep.answer > 0;
    bool taken = false;
    for (std::size_t i = 0; i < at.size(); ++i)
      if (const auto by = derived_.moved(buffer(step, i), regime_.moved); moves[i] && by)
        at[i] += *by, taken = true;
    if (!taken) at = steep.at;
    return steep.answer > 0;
  }

  void note_law(const Step& step, const std::vector<double>& at, const std::vector<bool>& moves,
                const SteepPlace& steep) {
    const auto input = index(steep.input);
    const auto from = derived_.of(buffer(step, input));
    std::vector<double> slopes(at.size(), 0.0);
    for (std::size_t i = 0; i < at.size(); ++i)
      if (const auto other = derived_.of(buffer(step, i)); moves[i] && other.source == from.source)
        slopes[i] = other.slope;
    const auto answer = [node = schedule_.nodes[index(step.node)], type = schedule_.types[index(step.node)],
                         at, moves, slopes](double moved) {
      auto there = at;
      for (std::size_t i = 0; i < there.size(); ++i) there[i] += slopes[i] * moved;
      return answer_at(*node, *type, there, moves);
    };
    graph_.laws.push_back(
        {prefix_ + path_of(step.path), from.source, (steep.at[input] - at[input]) / from.slope, answer});
  }

  /// `pulls_back`: at some place, as a spring does.
  void join_port(const Step& step, int input, int output, const std::vector<double>& at, bool pulls_back) {
    const auto& node = schedule_.nodes[index(step.node)];
    const auto* type = schedule_.types[index(step.node)].get();
    LinearEdge edge{.kind = LinearEdge::Kind::Node,
                    .from = signal(schedule_.inputs[index(step.first_in + input)]),
                    .to = places_.at(schedule_.outputs[index(step.first_out + output)]),
                    .path = prefix_ + path_of(step.path),
                    .frames = std::max(0, node->delay(input, output).most) * every(step),
                    .node = node,
                    .input = input,
                    .output = output,
                    .at = at,
                    .every = every(step)};
    const auto response = node->response(input, output, kSomewhere, at);
    if (!response) {
      if (const auto instead = stands_for(schedule_.whats[index(step.node)], input)) {
        edge.kind = LinearEdge::Kind::Gain;
        edge.gain = *instead;
      } else {
        edge.kind = LinearEdge::Kind::Event;
        note_event(edge, type, at);
      }
    } else if (type != nullptr && type->stateless && *response == 0.0) {
      return;
    } else if (type != nullptr && is_spring(*type, index(input), index(output))) {
      if (response->real() > 0 && pulls_back) return graph_.crests.push_back(edge.path);
      return add_stiff(edge, type->name, -response->real());
    }
    graph_.edges.push_back(std::move(edge));
  }

  /// A signal of its own between position and force, where the stiffness can be turned up.
  void add_stiff(LinearEdge edge, const std::string& type, double stiffness) {
    const int between = graph_.add_signal(edge.path);
    graph_.stiff.push_back({between, edge.path, type, stiffness, regime_.touched});
    graph_.join(between, edge.to);
    edge.to = between;
    graph_.edges.push_back(std::move(edge));
  }

  void note_event(const LinearEdge& edge, const NodeType* type, const std::vector<double>& at) {
    EventPlace place{edge.path, type != nullptr ? type->name : "phase delay", {}};
    const int hold = type != nullptr ? type->input_index("hold") : -1;
    if (hold >= 0) place.hold_s = at[index(hold)];
    const bool known = std::any_of(graph_.events.begin(), graph_.events.end(),
                                   [&](const auto& e) { return e.path == place.path; });
    if (!known) graph_.events.push_back(std::move(place));
  }

  void join_network(const Step& step) {
    const auto& node = schedule_.nodes[index(step.node)];
    const auto& view = dynamic_cast<const NetworkView&>(*node);
    const auto path = prefix_ + path_of(step.path);
    const auto touching = regime_.contacts.find(path);
    const auto model =
        LinearNetwork::make(view, *schedule_.types[index(step.node)],
                            touching == regime_.contacts.end() ? Touching{} : touching->second, regime_.hand);
    if (model == nullptr) return skip_network(step, path);
    const int number = static_cast<int>(graph_.networks.size());
    graph_.networks.push_back(model);
    graph_.network_paths.push_back(path);
    if (!model->whole()) return skip_network(step, path);
    for (std::size_t s = 0; s < model->signal_ports().size(); ++s) {
      const int from = signal(schedule_.inputs[index(step.first_in + model->signal_ports()[s])]);
      for (int o = 0; from >= 0 && o < step.outputs; ++o) {
        const auto* out = schedule_.outputs[index(step.first_out + o)];
        if (out != nullptr)
          graph_.edges.push_back({.kind = LinearEdge::Kind::Network,
                                  .from = from,
                                  .to = places_.at(out),
                                  .path = path,
                                  .frames = every(step),
                                  .input = static_cast<int>(s),
                                  .output = o,
                                  .network = number,
                                  .every = every(step)});
      }
    }
  }

  /// What goes in may come out, nobody knows how.
  void skip_network(const Step& step, const std::string& path) {
    graph_.not_looked_at.push_back(path);
    for (int i = 0; i < step.inputs; ++i)
      for (int o = 0; o < step.outputs; ++o) {
        const int from = signal(schedule_.inputs[index(step.first_in + i)]);
        const auto* out = schedule_.outputs[index(step.first_out + o)];
        if (from >= 0 && out != nullptr)
          graph_.edges.push_back(
              {.kind = LinearEdge::Kind::Event, .from = from, .to = places_.at(out), .path = path});
      }
  }

  LinearGraph& graph_;
  const Schedule& schedule_;
  const Regime& regime_;
  std::string prefix_;
  std::map<const double*, int> places_;
  Derivations derived_;
};

}  // namespace

Terminals add_schedule(LinearGraph& graph, const Schedule& schedule, const Regime& regime,
                       const std::string& prefix) {
  return ScheduleReader{graph, schedule, regime, prefix}.run();
}

}  // namespace tactus
