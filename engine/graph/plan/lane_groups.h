#pragma once

// Thread: [control].

#include <algorithm>
#include <memory>
#include <vector>

#include "engine/graph/plan/vertex_graph.h"

namespace tactus {

/// Lanes that are to be vectorised.
struct LaneGroup {
  static constexpr int kNone = -1;

  std::vector<int> members;  ///< vertices, lane by lane; kNone where a lane was left out or never was
  int first = 0;             ///< the first lane that is there
  std::unique_ptr<Node> node;
  bool remembers = false;
  int vertex = kNone;  ///< the vectorised one
};

/// What each lane reads; a wire without a vertex where there is no lane.
using LaneRow = std::vector<Wire>;

/// The wire of the first lane that is there.
const Wire& first_of(const LaneRow& row);

/// Whether this holds for every wire that is there.
template <class Condition>
bool all_of(const LaneRow& row, Condition holds) {
  return std::all_of(row.begin(), row.end(),
                     [&](const Wire& wire) { return wire.vertex == LaneGroup::kNone || holds(wire); });
}

/// Which lanes of a graph are worth vectorising: lanes 8k … 8k+7 of the same node or operator, where
/// half of them or more are there, and where one of the groups that read one another has a state.
class LaneGroups {
 public:
  /// [control] The nodes of the single lanes are made.
  LaneGroups(const VertexGraph& graph, const FlatGraph& flat);

  /// In the order of their first vertices, so that one file always gives one plan.
  std::vector<LaneGroup>& groups() { return groups_; }
  const LaneGroup& operator[](int group) const { return groups_[static_cast<std::size_t>(group)]; }
  /// Index in `groups`, or kNone.
  int group_of(const Wire& wire) const;
  /// What the lanes of a group read at input `i`.
  LaneRow input(const LaneGroup& group, std::size_t i) const;
  /// The group whose lanes these are, each in its place; kNone if there is no such group.
  int lined_up(const LaneRow& row) const;

 private:
  const Vertex& at(int v) const { return graph_.vertices[static_cast<std::size_t>(v)]; }
  void find();
  void make_node(LaneGroup& group) const;
  void drop_those_without_memory();
  void number_members();

  const VertexGraph& graph_;
  const FlatGraph& flat_;
  std::vector<LaneGroup> groups_;
  std::vector<int> group_of_;  ///< [scalar vertex]
};

}  // namespace tactus
