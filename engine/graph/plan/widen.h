#pragma once

#include "engine/graph/plan/make_nodes.h"
#include "engine/graph/plan/vertex_graph.h"

namespace tactus {

/// Puts lanes side by side: lanes 8k … 8k+7 of the same node, or of the same operator of an expression,
/// become one wide vertex (see Node::widened), so that a recurrence runs across voices instead of along time,
/// where four of them or more are there. What is wide reads what is wide as it stands, one scalar for all
/// lanes, or a Pack of scalars; scalars read one lane of what is wide. Only where nodes with a wide form and
/// a memory take part: operators alone are as fast along time. `made` gets the wide nodes, in the order of
/// the vertices; the scalar ones stay until `drop_replaced`. False: nothing is side by side, and `graph` is
/// as it was.
///
/// Lanes that run together have one sub-block, the shortest of theirs, and are reset together after a fault.
bool widen(VertexGraph& graph, const FlatGraph& flat, MadeNodes& made);

/// Frees the scalar nodes that wide ones stand for, once the wide graph is to stay.
void drop_replaced(const VertexGraph& graph, MadeNodes& made);

/// Drops the wide nodes: `graph`, as it was before, is to stay.
void undo_widen(const VertexGraph& graph, MadeNodes& made);

/// Turns each Sum that no node does into additions. False if there was none.
bool expand_sums(VertexGraph& graph, MadeNodes& made);

}  // namespace tactus
