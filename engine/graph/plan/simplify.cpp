#include <functional>
#include <map>
#include <optional>

#include "engine/graph/file/quantity.h"
#include "engine/graph/plan/inserted_nodes.h"
#include "engine/graph/plan/vertex_graph.h"
#include "engine/graph/semantics/expression.h"
#include "engine/graph/semantics/facts.h"

namespace tactus {
namespace {

class Simplifier {
  using Kind = Vertex::Kind;
  using Op = Expression::Op;

 public:
  Simplifier(VertexGraph& graph, const FlatGraph& flat, Hertz sample_rate)
      : graph_(graph), flat_(flat), sample_rate_(sample_rate) {}

  void run() {
    find_named();
    skip_copies();
    fold();
    sweep("reaches no output");
    zeros_ = true;
    fold();
    sweep("reaches only signals that are multiplied by zero");
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
    if (const auto values = constants(v))
      return make_constant(v, apply(vertex.op, values->front(), values->size() > 1 ? values->back() : 0));
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
    const auto& node = flat_.nodes[index(at(v).index)];
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

  bool fold_outputs(int v, const std::vector<double>& results) {
    const auto users = consumers_[index(v)];
    for (std::size_t port = 0; port < results.size(); ++port) {
      graph_.vertices.push_back({.value = results[port]});
      consumers_.push_back(users);
      const int made = static_cast<int>(graph_.vertices.size()) - 1;
      for (const int user : users)
        for (auto& wire : at(user).in)
          if (wire == Wire{v, static_cast<int>(port)}) wire = {made, 0};
    }
    return true;
  }

  // ---- pruning

  void sweep(const char* why) {
    std::vector<bool> reached(graph_.vertices.size(), false);
    std::vector<int> work;
    for (std::size_t v = 0; v < graph_.vertices.size(); ++v)
      if (graph_.vertices[v].kind == Kind::Output) work.push_back(static_cast<int>(v));
    while (!work.empty()) {
      const int v = work.back();
      work.pop_back();
      if (reached[index(v)]) continue;
      reached[index(v)] = true;
      for (const auto& wire : at(v).in) work.push_back(wire.vertex);
      if (at(v).kind == Kind::PhaseDelay) work.push_back(at(v).index);  // it asks that node for its phase
    }
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
  std::map<int, std::string> named_;  ///< vertices with a name in the file; why they are left out, or ""
};

}  // namespace

void simplify(VertexGraph& graph, const FlatGraph& flat, Hertz sample_rate) {
  Simplifier{graph, flat, sample_rate}.run();
}

}  // namespace tactus
