#include <algorithm>
#include <map>
#include <memory>
#include <utility>

#include "engine/graph/plan/fingerprint.h"
#include "engine/graph/plan/inserted_nodes.h"
#include "engine/graph/plan/vertex_graph.h"

namespace tactus {
namespace {

constexpr int kNone = -1;
/// From this many lanes on, eight at once cost less than one after the other.
constexpr std::ptrdiff_t kLeastLanes = 4;

/// Lanes that are to be vectorised.
struct LaneGroup {
  std::vector<int> members;  ///< vertices, lane by lane; kNone where a lane was left out or never was
  int first = 0;             ///< the first lane that is there
  std::unique_ptr<Node> node;
  bool has_state = false;  ///< it, or one that it reads or is read by
  int vertex = kNone;      ///< the vectorised one
};

/// What each lane reads; a wire without a vertex where there is no lane.
using LaneRow = std::vector<Wire>;

/// The wire of the first lane that is there.
const Wire& first_of(const LaneRow& row) {
  return *std::find_if(row.begin(), row.end(), [](const Wire& wire) { return wire.vertex != kNone; });
}

class Vectoriser {
 public:
  Vectoriser(VertexGraph& graph, const FlatGraph& flat) : graph_(graph), flat_(flat) {}

  bool run() {
    find_groups();
    drop_those_without_state();
    if (groups_.empty()) return false;
    const auto scalars = graph_.vertices.size();
    for (auto& group : groups_) add_vectorised(group);
    for (auto& group : groups_) connect(group);
    for (std::size_t v = 0; v < scalars; ++v) connect_scalar(static_cast<int>(v));
    for (const auto& group : groups_)
      for (const int member : group.members)
        if (member != kNone) at(member).alive = false;
    graph_.compact();
    return true;
  }

 private:
  Vertex& at(int v) { return graph_.vertices[index(v)]; }

  int add(Vertex vertex) {
    graph_.vertices.push_back(std::move(vertex));
    return static_cast<int>(graph_.vertices.size()) - 1;
  }

  // ---- lanes worth vectorising: 8k … 8k+7 of the same node or operator, where half of them or more are
  // there, and where one of the groups that read one another has a state

  void find_groups() {
    std::map<std::pair<Origin, int>, std::vector<int>> rows;
    for (std::size_t v = 0; v < graph_.vertices.size(); ++v) {
      const auto& vertex = graph_.vertices[v];
      const bool runs = vertex.kind == Vertex::Kind::Operation || vertex.kind == Vertex::Kind::Node;
      if (!vertex.alive || !vertex.origin || !runs) continue;
      auto& row = rows[{vertex.origin, vertex.lane / kVectorWidth}];
      row.resize(kVectorWidth, kNone);
      row[index(vertex.lane % kVectorWidth)] = static_cast<int>(v);
    }
    for (auto& [row, members] : rows) {
      if (kVectorWidth - std::count(members.begin(), members.end(), kNone) < kLeastLanes) continue;
      LaneGroup group;
      group.first = *std::find_if(members.begin(), members.end(), [](int v) { return v != kNone; });
      group.members = std::move(members);
      make_node(group);
      if (group.node != nullptr) groups_.push_back(std::move(group));
    }
    std::ranges::sort(groups_, {}, &LaneGroup::first);
    number_members();
  }

  void make_node(LaneGroup& group) {
    const auto& first = at(group.first);
    if (first.kind == Vertex::Kind::Operation) {
      group.node = std::make_unique<VectorOperation>(first.op);
      return;
    }
    group.has_state = !flat_.nodes[index(first.index)].type->stateless;
    std::vector<const Node*> lanes;
    for (const int v : group.members) lanes.push_back(v == kNone ? nullptr : at(v).node.get());
    group.node = first.node->vectorised(lanes);
  }

  void number_members() {
    group_of_.assign(graph_.vertices.size(), kNone);
    for (std::size_t g = 0; g < groups_.size(); ++g)
      for (const int v : groups_[g].members)
        if (v != kNone) group_of_[index(v)] = static_cast<int>(g);
  }

  /// Of groups that read one another, one must have a state.
  void drop_those_without_state() {
    std::vector<std::vector<int>> beside(groups_.size());
    for (std::size_t g = 0; g < groups_.size(); ++g)
      for (std::size_t i = 0; i < at(groups_[g].first).in.size(); ++i)
        if (const int read = lined_up(input(groups_[g], i)); read != kNone) {
          beside[g].push_back(read);
          beside[index(read)].push_back(static_cast<int>(g));
        }
    const auto has_state = [this](int g) { return groups_[index(g)].has_state; };
    for (const auto& together : strong_components(beside, Roots::FirstToLast))
      if (std::ranges::any_of(together, has_state))
        for (const int g : together) groups_[index(g)].has_state = true;
    std::erase_if(groups_, [](const LaneGroup& group) { return !group.has_state; });
    number_members();
  }

  /// Index in `groups_`, or kNone.
  int group_of(const Wire& wire) const { return group_of_[index(wire.vertex)]; }
  /// What the lanes of a group read at input `i`.
  LaneRow input(const LaneGroup& group, std::size_t i) {
    LaneRow row;
    for (const int v : group.members) row.push_back(v == kNone ? Wire{} : at(v).in[i]);
    return row;
  }
  /// The group whose lanes these are, each in its place; kNone if there is no such group.
  int lined_up(const LaneRow& row) const {
    const int g = group_of(first_of(row));
    if (g == kNone) return kNone;
    const auto& members = groups_[index(g)].members;
    for (std::size_t lane = 0; lane < row.size(); ++lane)
      if (row[lane].vertex != kNone && row[lane] != Wire{members[lane], first_of(row).port}) return kNone;
    return g;
  }

  // ---- vectorised vertices

  void add_vectorised(LaneGroup& group) {
    Vertex vectorised = at(group.first);
    const int first = vectorised.lane / kVectorWidth * kVectorWidth,
              last = std::min(first + kVectorWidth, vectorised.lanes) - 1;
    // Lanes of a node are named one by one, operators after their expression.
    if (vectorised.kind == Vertex::Kind::Node) vectorised.path.resize(vectorised.path.rfind('['));
    vectorised.path += "[" + std::to_string(first) + ".." + std::to_string(last) + "]";
    vectorised.origin = {};
    vectorised.width = kVectorWidth;
    vectorised.in.clear();
    vectorised.node = std::move(group.node);
    vectorised.fingerprint = made_from(group);
    group.vertex = add(std::move(vectorised));
  }

  /// What its lanes were made from.
  std::uint64_t made_from(const LaneGroup& group) {
    Fingerprint print;
    for (const int v : group.members) {
      print.add(std::uint64_t{v == kNone});
      if (v == kNone) continue;
      const bool operation = at(v).kind == Vertex::Kind::Operation;
      print.add(operation ? static_cast<std::uint64_t>(at(v).op) : at(v).fingerprint);
    }
    return print.value();
  }

  void connect(const LaneGroup& group) {
    std::vector<Wire> in;
    for (std::size_t i = 0; i < at(group.first).in.size(); ++i)
      in.push_back(vector_input(input(group, i), at(group.vertex)));
    // Every operation has two operands to point at.
    if (at(group.vertex).kind == Vertex::Kind::Operation && in.size() == 1) in.push_back(in[0]);
    at(group.vertex).in = std::move(in);
  }

  Wire vector_input(const LaneRow& row, const Vertex& reader) {
    if (const int g = lined_up(row); g != kNone) return all_lanes(g, row);
    auto wires = row;  // what a lane reads that is not there changes nothing
    std::replace(wires.begin(), wires.end(), Wire{}, first_of(row));
    const auto constant = [&](Wire wire) { return at(wire.vertex).kind == Vertex::Kind::Constant; };
    if (std::ranges::all_of(wires, constant)) return constants(wires);
    if (std::ranges::count(wires, wires[0]) == kVectorWidth) return scalar(wires[0], reader.path);
    return packed(wires, reader.path, reader.divisor);
  }

  Wire all_lanes(int group, const LaneRow& row) const {
    return {groups_[index(group)].vertex, first_of(row).port, Wire::kAllLanes};
  }

  Wire constants(const LaneRow& row) {
    Vertex vertex{.width = kVectorWidth};
    for (const auto& wire : row) vertex.values.push_back(at(wire.vertex).value);
    return {add(std::move(vertex)), 0, Wire::kAllLanes};
  }

  Wire packed(LaneRow wires, std::string path, int divisor) {
    for (auto& wire : wires) wire = lane_of(wire);
    wires.resize(kVectorWidth, wires[0]);
    const auto [known, fresh] = packs_.try_emplace({wires, divisor});
    if (!fresh) return known->second;
    const int vertex = add({.kind = Vertex::Kind::Pack,
                            .width = kVectorWidth,
                            .divisor = divisor,
                            .in = std::move(wires),
                            .path = std::move(path),
                            .node = std::make_shared<Pack>()});
    return known->second = {vertex, 0, Wire::kAllLanes};
  }

  // ---- what stays scalar

  /// Where the signal is now: on its own, or a lane of a vectorised vertex.
  Wire lane_of(const Wire& wire) const {
    const int g = group_of(wire);
    if (g == kNone) return wire;
    const auto& group = groups_[index(g)];
    const auto lane = std::find(group.members.begin(), group.members.end(), wire.vertex);
    return {group.vertex, wire.port, static_cast<int>(lane - group.members.begin())};
  }

  /// Its samples in a row.
  Wire scalar(const Wire& wire, std::string path) {
    if (group_of(wire) == kNone) return wire;
    const auto lane = lane_of(wire);
    const auto [known, fresh] = rows_.try_emplace(lane);
    if (!fresh) return known->second;
    return known->second = {add({.kind = Vertex::Kind::Operation,
                                 .op = Expression::Op::Signal,
                                 .divisor = at(wire.vertex).divisor,
                                 .in = {lane},
                                 .path = std::move(path)})};
  }

  void connect_scalar(int v) {
    if (!at(v).alive || group_of({v, 0}) != kNone) return;
    if (at(v).kind == Vertex::Kind::Sum && sum_vectorised(v)) return;
    const bool takes_lanes = at(v).kind == Vertex::Kind::Output;
    auto in = at(v).in;
    for (auto& wire : in) wire = takes_lanes ? lane_of(wire) : scalar(wire, at(v).path);
    at(v).in = std::move(in);
  }

  /// False if none of its lanes are vectorised.
  bool sum_vectorised(int v) {
    const auto lanes = at(v).in;
    std::vector<LaneRow> rows;
    for (std::size_t lane = 0; lane < lanes.size(); ++lane) {
      if (lane % kVectorWidth == 0) rows.emplace_back();
      rows.back().push_back(lanes[lane]);
    }
    if (std::none_of(rows.begin(), rows.end(), [this](const LaneRow& row) { return lined_up(row) != kNone; }))
      return false;
    LaneRow in;
    for (const auto& row : rows) {
      const int g = lined_up(row);
      in.push_back(g == kNone ? packed(row, at(v).path, at(v).divisor) : all_lanes(g, row));
    }
    at(v).in = std::move(in);
    at(v).node = std::make_shared<LaneSum>(static_cast<int>(lanes.size()));
    at(v).fingerprint = lanes.size();
    return true;
  }

  VertexGraph& graph_;
  const FlatGraph& flat_;
  std::vector<LaneGroup> groups_;  ///< in the order of their first vertices, so that one file gives one plan
  std::vector<int> group_of_;      ///< [scalar vertex]
  std::map<std::pair<LaneRow, int>, Wire> packs_;  ///< of these lanes at this rate divisor
  std::map<Wire, Wire> rows_;
};

}  // namespace

bool vectorise(VertexGraph& graph, const FlatGraph& flat) { return Vectoriser{graph, flat}.run(); }

void expand_sums(VertexGraph& graph) {
  for (std::size_t v = 0; v < graph.vertices.size(); ++v) {
    if (graph.vertices[v].kind != Vertex::Kind::Sum || graph.vertices[v].node != nullptr) continue;
    const auto lanes = graph.vertices[v].in;
    Vertex addition = graph.vertices[v];
    addition.kind = Vertex::Kind::Operation;
    addition.op = Expression::Op::Add;
    add_lanes(lanes, [&](Wire a, Wire b) {
      addition.in = {a, b};
      graph.vertices.push_back(addition);
      return Wire{static_cast<int>(graph.vertices.size()) - 1, 0};
    });
    graph.vertices.pop_back();  // the last one takes the place of the sum
    graph.vertices[v] = std::move(addition);
  }
}

}  // namespace tactus
