#pragma once

#include <memory>
#include <vector>

#include "engine/core/error.h"
#include "engine/graph/plan/compile.h"
#include "engine/graph/plan/vertex_graph.h"

namespace tactus {

/// The running nodes of the vertices that are left, in the order of the vertices (nullptr where a vertex is
/// no node or could not be made).
struct MadeNodes {
  std::vector<std::shared_ptr<Node>> nodes;
  std::vector<std::uint64_t> fingerprints;  ///< of `nodes`: what they were made from
  std::vector<bool> frozen_controls;        ///< their value was needed to make a node
  std::vector<Error> mistakes;              ///< why nodes could not be made: they are nullptr
};

/// Phase delays that never change become constants of `graph`.
MadeNodes make_nodes(VertexGraph& graph, const FlatGraph& flat, const CompileOptions& options);

}  // namespace tactus
