#pragma once

#include "engine/graph/plan/compile.h"
#include "engine/graph/plan/make_nodes.h"
#include "engine/graph/plan/order.h"

namespace tactus {

/// Lays the ordered vertices out as a flat list of steps over one arena.
std::unique_ptr<Schedule> build_schedule(const VertexGraph& graph, const FlatGraph& flat,
                                         const std::vector<OrderedSection>& sections, MadeNodes made,
                                         const CompileOptions& options);

}  // namespace tactus
