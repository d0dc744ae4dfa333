#pragma once

#include <memory>
#include <vector>

#include "engine/core/error.h"
#include "engine/graph/plan/compile.h"
#include "engine/graph/plan/vertex_graph.h"

// Thread: [control].

namespace tactus {

// The passes of `compile` behind `lower` and `simplify`.

struct MadeNodes {
  std::vector<bool> frozen_controls;  ///< their value was needed to make a node
  std::vector<Error> mistakes;        ///< why nodes could not be made: they are nullptr
};

/// Makes the node of every vertex that has one. Phase delays that never change become constants of `graph`.
MadeNodes make_nodes(VertexGraph& graph, const FlatGraph& flat, const CompileOptions& options);

/// One vertex at one place of the order: whole, or one half of it.
struct OrderedVertex {
  enum class Half { Whole, Emit, Absorb, Outside } half = Half::Whole;
  int vertex = -1;
};

/// Vertices that run together: a loop, or everything between two loops.
struct OrderedSection {
  std::vector<OrderedVertex> vertices;
  bool loop = false;
  int sub_block = kMaxSubBlock;  ///< the largest S for which delays of S frames and more cut every cycle
  int delay_frames = 0;          ///< the shortest of the delays that cut
};

/// Puts the vertices in an order in which everything runs after what it reads. Strongly connected parts
/// become loops with the largest possible sub-block. With `closed_outside`, a vertex that represents the
/// world outside is put between all outputs and all inputs. Errors: one Cycle for each part of the graph with
/// a loop without a delay, naming the loop edge by edge.
Checked<std::vector<OrderedSection>> order(const VertexGraph& graph, bool closed_outside);

/// Lays the ordered vertices out as a flat list of steps over one arena.
std::unique_ptr<Plan> build_plan(VertexGraph graph, const FlatGraph& flat,
                                 const std::vector<OrderedSection>& sections,
                                 const std::vector<bool>& frozen_controls, const CompileOptions& options);

}  // namespace tactus
