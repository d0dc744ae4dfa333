#include <algorithm>
#include <functional>
#include <map>
#include <optional>
#include <set>

#include "engine/graph/file/quantity.h"
#include "engine/graph/plan/inserted_nodes.h"
#include "engine/graph/plan/vertex_graph.h"
#include "engine/graph/semantics/facts.h"
#include "engine/graph/semantics/operators.h"

namespace tactus {
namespace {

class Simplifier {
  using Kind = Vertex::Kind;
  using Op = Expression::Op;

 public:
  Simplifier(VertexGraph& graph, const FlatGraph& flat, Hertz sample_rate)
      : graph_(graph), flat_(flat), sample_rate_(sample_rate) {}

  void run() {
    for (const auto& vertex : graph_.vertices)
      if (vertex.kind == Kind::PhaseDelay) asked_for_phase_.insert(vertex.index);
    find_named();
    skip_copies();
    fold();
    sweep("reaches no output");
    zeros_ = true;
    fold();
    sweep("reaches only signals that are multiplied by zero");
    disconnect_unneeded();
    report_left_out();
    graph_.compact();
  }

 private:
  Vertex& at(int v) { return graph_.vertices[index(v)]; }
  std::optional<double> constant(Wire wire) {
    const auto& vertex = at(wire.vertex);
    return vertex.kind == Kind::Constant ? std::optional{vertex.value} : std::nullopt;
  }

  /// Of all inputs, if all are constant.
  std::optional<std::vector<double>> constants(int v) {
    std::vector<double> values;
    for (const auto& wire : at(v).in)
      if (const auto value = constant(wire)) values.push_back(*value);
    return values.size() == at(v).in.size() ? std::optional{std::move(values)} : std::nullopt;
  }

  /// A constant that all lanes have in common: where one lane skips what the others do, they no longer match.
  std::optional<double> same_in_all(Wire wire) {
    return at(wire.vertex).origin ? std::nullopt : constant(wire);
  }

  // ---- copies

  bool is_copy(const Vertex& v) const { return v.kind == Kind::Operation && v.op == Op::Signal; }

  Wire behind_copies(Wire wire) {
    const Wire first = wire;
    for (auto left = graph_.vertices.size(); is_copy(at(wire.vertex)); --left) {
      if (left == 0) return first;  // names that only name each other: the ordering reports the loop
      wire = at(wire.vertex).in.front();
    }
    return wire;
  }

  void skip_copies() {
    for (auto& vertex : graph_.vertices)
      for (auto& wire : vertex.in) wire = behind_copies(wire);
  }

  // ---- folding

  void fold() {
    consumers_.assign(graph_.vertices.size(), {});
    for (std::size_t v = 0; v < graph_.vertices.size(); ++v)
      for (const auto& wire : graph_.vertices[v].in)
        consumers_[index(wire.vertex)].push_back(static_cast<int>(v));
    std::vector<int> work;
    for (int v = static_cast<int>(graph_.vertices.size()) - 1; v >= 0; --v) work.push_back(v);
    while (!work.empty()) {
      const int v = work.back();
      work.pop_back();
      if (!at(v).alive || !try_fold(v)) continue;
      for (const int consumer : consumers_[index(v)]) work.push_back(consumer);
    }
  }

  /// True if consumers of `v` now see something simpler.
  bool try_fold(int v) {
    if (at(v).kind == Kind::Operation && !is_copy(at(v))) return fold_operation(v);
    if (at(v).kind == Kind::Node) return fold_node(v);
    if (at(v).kind != Kind::Sum && at(v).kind != Kind::RateConverter) return false;
    const auto values = constants(v);  // what never changes is the same at every rate
    return values && make_constant(v, add_lanes(*values, std::plus<>{}));
  }

  bool fold_operation(int v) {
    auto& vertex = at(v);
    if (auto values = constants(v)) {
      values->resize(kMostOperands);
      return make_constant(v, evaluate(vertex.op, (*values)[0], (*values)[1], (*values)[2]));
    }
    if (vertex.op == Op::Multiply) {
      for (std::size_t i = 0; i < 2; ++i) {
        if (same_in_all(vertex.in[i]) == 1.0) return replace(v, vertex.in[1 - i]);
        if (zeros_ && constant(vertex.in[i]) == 0.0) return make_constant(v, 0);
      }
    }
    if (vertex.op == Op::Divide && same_in_all(vertex.in[1]) == 1.0) return replace(v, vertex.in[0]);
    // Of all numbers this changes -0 only, which no operation distinguishes from 0.
    if ((vertex.op == Op::Add || vertex.op == Op::Subtract) && same_in_all(vertex.in[1]) == 0.0)
      return replace(v, vertex.in[0]);
    if (vertex.op == Op::Add && same_in_all(vertex.in[0]) == 0.0) return replace(v, vertex.in[1]);
    return false;
  }

  bool make_constant(int v, double value) {
    at(v).kind = Kind::Constant;
    at(v).value = value;
    at(v).in.clear();
    return true;
  }

  bool replace(int v, Wire with) {
    if (with.vertex == v) return false;  // it reads itself: the ordering reports the loop
    for (const int consumer : consumers_[index(v)])
      for (auto& wire : at(consumer).in)
        if (wire.vertex == v) {
          wire = with;
          consumers_[index(with.vertex)].push_back(consumer);
        }
    return true;
  }

  bool fold_node(int v) {
    const auto& node = node_of(v);
    if (fold_silent(v)) return true;
    if (!node.type->stateless) return false;
    const auto values = constants(v);
    if (!values) return false;
    auto setup = setup_of(node, sample_rate_);
    for (std::size_t i = 0; i < values->size(); ++i)
      setup.inputs.push_back({Interval::exactly((*values)[i]), (*values)[i], node.inputs[i].has_value()});
    const auto made = node.type->make(setup);
    if (!made) return false;  // reported when it is made for good
    std::vector<Signal> in;
    for (const auto& value : *values) in.push_back({&value, 0});
    std::vector<double> results(index(at(v).outputs));
    std::vector<double*> out;
    for (auto& result : results) out.push_back(&result);
    (*made)->process({in.data(), out.data(), 1, 0});
    return results.size() == 1 ? make_constant(v, results[0]) : fold_outputs(v, results);
  }

  /// Outputs that an input keeps at 0. A node whose phase is asked for must be there to answer.
  bool fold_silent(int v) {
    const auto& type = *node_of(v).type;
    std::vector<bool> silent(type.outputs.size());
    for (const auto& [input, output] : type.silencers) {
      if (constant(at(v).in[index(type.input_index(input))]) != 0.0) continue;
      for (std::size_t o = 0; o < silent.size(); ++o)
        silent[o] = silent[o] || output.empty() || type.outputs[o].name == output;
    }
    const bool all = std::find(silent.begin(), silent.end(), false) == silent.end();
    if (all && silent.size() == 1 && !asked_for_phase_.contains(v)) return make_constant(v, 0);
    bool any = false;
    for (std::size_t o = 0; o < silent.size(); ++o) any = (silent[o] && fold_output(v, o, 0)) || any;
    return any;
  }

  /// False: nothing reads that output.
  bool fold_output(int v, std::size_t port, double value) {
    const auto users = consumers_[index(v)];
    const Wire from{v, static_cast<int>(port)};
    const auto reads = [&](int user) { return std::ranges::find(at(user).in, from) != at(user).in.end(); };
    if (std::ranges::none_of(users, reads)) return false;
    graph_.vertices.push_back({.value = value, .at = at(v).at});
    consumers_.push_back(users);
    const int made = static_cast<int>(graph_.vertices.size()) - 1;
    for (const int user : users) std::ranges::replace(at(user).in, from, Wire{made, 0});
    return true;
  }

  bool fold_outputs(int v, const std::vector<double>& results) {
    for (std::size_t port = 0; port < results.size(); ++port) fold_output(v, port, results[port]);
    return true;
  }

  // ---- pruning

  /// What outputs are made of. Nodes that may not need all of their inputs come last, when it is known what
  /// is read of them; what they then reach may read more of them.
  void sweep(const char* why) {
    std::vector<bool> reached(graph_.vertices.size(), false);
    std::vector<Wire> work;
    reads_.clear();
    for (std::size_t v = 0; v < graph_.vertices.size(); ++v)
      if (graph_.vertices[v].kind == Kind::Output) work.push_back({static_cast<int>(v), 0});
    do {
      while (!work.empty()) {
        const auto [v, port, lane] = work.back();
        work.pop_back();
        if (chooses_inputs(v)) note_read(v, port);
        if (reached[index(v)]) continue;
        reached[index(v)] = true;
        if (!chooses_inputs(v)) work.insert(work.end(), at(v).in.begin(), at(v).in.end());
        if (at(v).kind == Kind::PhaseDelay)
          work.push_back({at(v).index, 0});  // it asks that node for its phase
      }
      for (auto& [v, read] : reads_) find_needed(v, read, work);
    } while (!work.empty());
    for (auto& [v, reason] : named_) {
      if (!reason.empty()) continue;
      if (at(v).kind == Kind::Constant)
        reason = "is always " + short_number(at(v).value);
      else if (!reached[index(v)])
        reason = why;
    }
    for (std::size_t v = 0; v < graph_.vertices.size(); ++v)
      if (!reached[v]) graph_.vertices[v].alive = false;
  }

  const FlatNode& node_of(int v) { return flat_.nodes[index(at(v).index)]; }
  bool chooses_inputs(int v) { return at(v).kind == Kind::Node && node_of(v).type->needed_inputs != nullptr; }

  /// What is read of a node that chooses its inputs, and which it needs for it.
  struct Read {
    std::vector<bool> outputs, needed;
    bool known = false;  ///< `needed` is that of `outputs`
  };

  void note_read(int v, int port) {
    auto& read = reads_[v];
    read.outputs.resize(index(at(v).outputs));
    if (read.outputs[index(port)]) return;
    read.outputs[index(port)] = true;
    read.known = false;
  }

  /// Adds the inputs that are needed now and were not before.
  void find_needed(int v, Read& read, std::vector<Wire>& work) {
    if (read.known) return;
    const auto& node = node_of(v);
    auto setup = setup_of(node, sample_rate_, at(v).lane);
    setup.read = read.outputs;
    for (std::size_t i = 0; i < at(v).in.size(); ++i)
      setup.inputs.push_back({node.ranges[i], constant(at(v).in[i]), node.inputs[i].has_value()});
    auto needed = node.type->needed_inputs(setup);
    read.needed.resize(needed.size());
    for (std::size_t i = 0; i < needed.size(); ++i)
      if (needed[i] && !read.needed[i]) work.push_back(at(v).in[i]);
    read.needed = std::move(needed);
    read.known = true;
  }

  /// Inputs that are not needed read a constant: what led to them is gone.
  void disconnect_unneeded() {
    for (const auto& [v, read] : reads_)
      for (std::size_t i = 0; i < read.needed.size(); ++i) {
        if (read.needed[i]) continue;
        const double value = constant(at(v).in[i]).value_or(node_of(v).type->inputs[i].fallback.value_or(0));
        graph_.vertices.push_back({.value = value, .at = at(v).at});
        at(v).in[i] = {static_cast<int>(graph_.vertices.size()) - 1, 0};
      }
  }

  /// Only what has a name of its own in the file is worth a line.
  void find_named() {
    for (int v = 0; v < static_cast<int>(graph_.vertices.size()); ++v) {
      const auto& vertex = at(v);
      if (vertex.kind == Kind::Node || vertex.kind == Kind::Control || vertex.kind == Kind::Input ||
          vertex.kind == Kind::RateConverter || is_copy(vertex))
        named_[v] = {};
    }
  }

  void report_left_out() {
    for (auto& [v, reason] : named_) {
      if (reason.empty()) continue;
      const auto& vertex = at(v);
      if (is_copy(vertex)) {
        // A name for something else: gone without loss when what it names lives on.
        const auto& behind = at(behind_copies({v, 0}).vertex);
        if (behind.kind == Kind::Constant)
          reason = "is always " + short_number(behind.value);
        else if (behind.alive || behind.kind == Kind::Node)
          continue;
      }
      graph_.left_out.push_back(
          {vertex.path, vertex.kind == Kind::Control ? "its output is not used" : reason});
    }
  }

  VertexGraph& graph_;
  const FlatGraph& flat_;
  Hertz sample_rate_;
  bool zeros_ = false;
  std::vector<std::vector<int>> consumers_;
  std::set<int> asked_for_phase_;     ///< nodes whose phase delay others compensate
  std::map<int, Read> reads_;         ///< nodes that choose their inputs, reached by the last sweep
  std::map<int, std::string> named_;  ///< vertices with a name in the file; why they are left out, or ""
};

}  // namespace

void simplify(VertexGraph& graph, const FlatGraph& flat, Hertz sample_rate) {
  Simplifier{graph, flat, sample_rate}.run();
}

}  // namespace tactus
