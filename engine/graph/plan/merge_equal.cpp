#include <algorithm>
#include <bit>
#include <cstdint>
#include <numeric>
#include <unordered_map>

#include "engine/graph/plan/fingerprint.h"
#include "engine/graph/plan/vertex_graph.h"
#include "engine/graph/semantics/flat_graph.h"

namespace tactus {
namespace {

class Merger {
  using Kind = Vertex::Kind;

 public:
  Merger(VertexGraph& graph, const FlatGraph& flat) : graph_(graph), flat_(flat) {}

  /// What reads two equal vertices may be equal itself. Operations are compared, but only nodes are merged:
  /// an operation costs little, and is found again after an edit by its place in its expression.
  void run() {
    same_.resize(graph_.vertices.size());
    std::iota(same_.begin(), same_.end(), 0);
    consumers_.resize(graph_.vertices.size());
    for (int v = static_cast<int>(graph_.vertices.size()) - 1; v >= 0; --v) {
      work_.push_back(v);
      for (const auto& wire : at(v).in) consumers_[index(wire.vertex)].push_back(v);
    }
    while (!work_.empty()) {
      const int v = work_.back();
      work_.pop_back();
      if (same_[index(v)] == v && may_merge(at(v))) compare(v);
    }
    merge();
    sweep();
    graph_.compact();
  }

 private:
  Vertex& at(int v) { return graph_.vertices[index(v)]; }
  const Vertex& at(int v) const { return graph_.vertices[index(v)]; }
  const FlatNode& node_of(const Vertex& vertex) const { return flat_.nodes[index(vertex.index)]; }

  bool may_merge(const Vertex& vertex) const {
    if (vertex.lanes > 1) return false;
    if (vertex.kind != Kind::Node)
      return vertex.kind == Kind::Operation || vertex.kind == Kind::RateConverter;
    return !vertex.type->random && node_of(vertex).compensate.empty();
  }

  /// Constants are the same if their numbers are.
  std::uint64_t source(const Wire& wire) const {
    const auto& from = at(wire.vertex);
    if (from.kind == Kind::Constant) return std::bit_cast<std::uint64_t>(from.value);
    return Fingerprint{}
        .add(static_cast<std::uint64_t>(same(wire)))
        .add(static_cast<std::uint64_t>(wire.port))
        .value();
  }
  bool same_source(const Wire& a, const Wire& b) const {
    const auto &one = at(a.vertex), &other = at(b.vertex);
    if (one.kind != Kind::Constant || other.kind != Kind::Constant)
      return same(a) == same(b) && a.port == b.port && a.lane == b.lane;
    return std::bit_cast<std::uint64_t>(one.value) == std::bit_cast<std::uint64_t>(other.value);
  }
  int same(const Wire& wire) const { return first(wire.vertex); }
  int first(int v) const {
    while (same_[index(v)] != v) v = same_[index(v)];
    return v;
  }

  std::uint64_t hash(const Vertex& vertex) const {
    Fingerprint print;
    print.add(static_cast<std::uint64_t>(vertex.kind)).add(static_cast<std::uint64_t>(vertex.op));
    print.add(static_cast<std::uint64_t>(vertex.divisor));
    if (vertex.kind == Kind::Node) print.add(vertex.type->name).add(vertex.type->fingerprint);
    for (const auto& wire : vertex.in) print.add(source(wire));
    return print.value();
  }

  bool equal(const Vertex& a, const Vertex& b) const {
    if (a.kind != b.kind || a.op != b.op || a.divisor != b.divisor || a.outputs != b.outputs) return false;
    if (!std::ranges::equal(a.in, b.in, [&](const Wire& x, const Wire& y) { return same_source(x, y); }))
      return false;
    if (a.kind == Kind::RateConverter)
      return a.conversion.from == b.conversion.from && a.conversion.how == b.conversion.how;
    return a.kind != Kind::Node ||
           (a.type->name == b.type->name && a.type->fingerprint == b.type->fingerprint &&
            node_of(a).settings == node_of(b).settings);
  }

  void compare(int v) {
    auto& alike = known_[hash(at(v))];
    const auto twin = std::ranges::find_if(
        alike, [&](int u) { return u != v && same_[index(u)] == u && equal(at(u), at(v)); });
    if (twin == alike.end()) return alike.push_back(v);
    same_[index(v)] = *twin;
    for (const int consumer : consumers_[index(v)]) {
      consumers_[index(*twin)].push_back(consumer);
      work_.push_back(consumer);
    }
  }

  bool gone(int v) const { return same_[index(v)] != v && at(v).kind != Kind::Operation; }

  void merge() {
    for (int v = 0; v < static_cast<int>(graph_.vertices.size()); ++v) {
      auto& vertex = at(v);
      for (auto& wire : vertex.in)
        if (gone(wire.vertex)) wire.vertex = same(wire);
      if (vertex.kind == Kind::PhaseDelay && gone(vertex.index)) vertex.index = first(vertex.index);
      if (!gone(v)) continue;
      auto& kept = at(first(v));
      kept.also.push_back(vertex.path);
      if (vertex.kind == Kind::Node) graph_.left_out.push_back({vertex.path, "equals '" + kept.path + "'"});
    }
  }

  /// Operations that only led to what is gone.
  void sweep() {
    std::vector<bool> reached(graph_.vertices.size());
    std::vector<int> work;
    for (int v = 0; v < static_cast<int>(graph_.vertices.size()); ++v)
      if (at(v).kind == Kind::Output) work.push_back(v);
    while (!work.empty()) {
      const int v = work.back();
      work.pop_back();
      if (reached[index(v)]) continue;
      reached[index(v)] = true;
      for (const auto& wire : at(v).in) work.push_back(wire.vertex);
      if (at(v).kind == Kind::PhaseDelay) work.push_back(at(v).index);
    }
    for (std::size_t v = 0; v < reached.size(); ++v) graph_.vertices[v].alive = reached[v];
  }

  VertexGraph& graph_;
  const FlatGraph& flat_;
  std::vector<int> same_;  ///< [vertex] one that is equal to it; itself, if it is the first
  std::vector<std::vector<int>> consumers_;
  std::vector<int> work_;  ///< from the first in the file on
  std::unordered_map<std::uint64_t, std::vector<int>> known_;
};

}  // namespace

void merge_equal(VertexGraph& graph, const FlatGraph& flat) { Merger{graph, flat}.run(); }

}  // namespace tactus
