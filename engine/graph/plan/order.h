#pragma once

#include <memory>
#include <vector>

#include "engine/core/error.h"
#include "engine/graph/node.h"
#include "engine/graph/plan/vertex_graph.h"

namespace tactus {

/// One vertex at one place of the order: whole, or one half of it.
struct OrderedVertex {
  enum class Half { Whole, Emit, Absorb, Outside } half = Half::Whole;
  int vertex = -1;
};

/// Vertices that run together: a loop, or all that stands between two loops.
struct OrderedSection {
  std::vector<OrderedVertex> vertices;
  bool loop = false;
  int sub_block = kMaxPiece;  ///< the largest S for which delays of S frames and more cut every cycle
  int delay_frames = 0;       ///< the shortest of the delays that cut
};

/// Puts the vertices in an order in which everything runs after what it reads. Strongly connected parts
/// become loops with the largest possible sub-block. `late[v][i]`: input i of vertex v is late, and
/// `least[v]` is the guaranteed delay from v's late inputs to its outputs. With `closed_outside`, a vertex
/// that stands for the world outside is put between all outputs and all inputs. Errors: one
/// Cycle for each part of the graph that goes round without a delay, naming a loop edge by edge.
Checked<std::vector<OrderedSection>> order(const VertexGraph& graph,
                                           const std::vector<std::vector<bool>>& late,
                                           const std::vector<int>& least, bool closed_outside);

}  // namespace tactus
