#include "engine/graph/plan/lane_groups.h"

#include <map>
#include <numeric>
#include <utility>

#include "engine/graph/plan/vector_nodes.h"

namespace tactus {
namespace {

/// From this many voices on, eight at once cost less than one after the other.
constexpr std::ptrdiff_t kLeastLanes = 4;

constexpr int kNone = LaneGroup::kNone;

}  // namespace

const Wire& first_of(const LaneRow& row) {
  return *std::find_if(row.begin(), row.end(), [](const Wire& wire) { return wire.vertex != kNone; });
}

LaneGroups::LaneGroups(const VertexGraph& graph, const FlatGraph& flat) : graph_(graph), flat_(flat) {
  find();
  drop_those_without_memory();
}

int LaneGroups::group_of(const Wire& wire) const { return group_of_[static_cast<std::size_t>(wire.vertex)]; }

void LaneGroups::find() {
  std::map<std::pair<Origin, int>, std::vector<int>> rows;
  for (std::size_t v = 0; v < graph_.vertices.size(); ++v) {
    const auto& vertex = graph_.vertices[v];
    const bool runs = vertex.kind == Vertex::Kind::Operation || vertex.kind == Vertex::Kind::Node;
    if (!vertex.alive || !vertex.origin || !runs) continue;
    auto& row = rows[{vertex.origin, vertex.lane / kVectorWidth}];
    row.resize(kVectorWidth, kNone);
    row[static_cast<std::size_t>(vertex.lane % kVectorWidth)] = static_cast<int>(v);
  }
  for (auto& [row, members] : rows) {
    if (kVectorWidth - std::count(members.begin(), members.end(), kNone) < kLeastLanes) continue;
    LaneGroup group;
    group.members = std::move(members);
    group.first = *std::find_if(group.members.begin(), group.members.end(), [](int v) { return v != kNone; });
    make_node(group);
    if (group.node != nullptr) groups_.push_back(std::move(group));
  }
  std::sort(groups_.begin(), groups_.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  number_members();
}

void LaneGroups::make_node(LaneGroup& group) const {
  const auto& first = at(group.first);
  if (first.kind == Vertex::Kind::Operation) {
    group.node = std::make_unique<VectorOperation>(first.op);
    return;
  }
  group.remembers = !flat_.nodes[static_cast<std::size_t>(first.index)].type->stateless;
  std::vector<const Node*> lanes;
  for (const int v : group.members) lanes.push_back(v == kNone ? nullptr : at(v).node.get());
  group.node = first.node->vectorised(lanes);
}

void LaneGroups::number_members() {
  group_of_.assign(graph_.vertices.size(), -1);
  for (std::size_t g = 0; g < groups_.size(); ++g)
    for (const int v : groups_[g].members)
      if (v != kNone) group_of_[static_cast<std::size_t>(v)] = static_cast<int>(g);
}

LaneRow LaneGroups::input(const LaneGroup& group, std::size_t i) const {
  LaneRow row;
  for (const int v : group.members) row.push_back(v == kNone ? Wire{} : at(v).in[i]);
  return row;
}

int LaneGroups::lined_up(const LaneRow& row) const {
  const int g = group_of(first_of(row));
  if (g == kNone) return kNone;
  const auto& members = groups_[static_cast<std::size_t>(g)].members;
  for (std::size_t lane = 0; lane < row.size(); ++lane)
    if (row[lane].vertex != kNone && row[lane] != Wire{members[lane], first_of(row).port}) return kNone;
  return g;
}

/// Of groups that read one another, one must remember something.
void LaneGroups::drop_those_without_memory() {
  std::vector<int> leader(groups_.size());
  std::iota(leader.begin(), leader.end(), 0);
  const auto find = [&](int g) {
    while (leader[static_cast<std::size_t>(g)] != g) {
      auto& next = leader[static_cast<std::size_t>(g)];
      g = next = leader[static_cast<std::size_t>(next)];
    }
    return g;
  };
  for (std::size_t g = 0; g < groups_.size(); ++g)
    for (std::size_t i = 0; i < at(groups_[g].first).in.size(); ++i)
      if (const int read = lined_up(input(groups_[g], i)); read != kNone)
        leader[static_cast<std::size_t>(find(read))] = find(static_cast<int>(g));
  std::vector<bool> remembers(groups_.size(), false);
  for (std::size_t g = 0; g < groups_.size(); ++g)
    if (groups_[g].remembers) remembers[static_cast<std::size_t>(find(static_cast<int>(g)))] = true;
  std::vector<LaneGroup> kept;
  for (std::size_t g = 0; g < groups_.size(); ++g)
    if (remembers[static_cast<std::size_t>(find(static_cast<int>(g)))]) kept.push_back(std::move(groups_[g]));
  groups_ = std::move(kept);
  number_members();
}

}  // namespace tactus
