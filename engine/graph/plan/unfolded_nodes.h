#pragma once

#include <cstddef>

#include "engine/graph/semantics/flat_graph.h"

namespace tactus {

/// How many nodes and operators a graph becomes when every lane stands on its own.
std::size_t unfolded_nodes(const FlatGraph& graph);

}  // namespace tactus
