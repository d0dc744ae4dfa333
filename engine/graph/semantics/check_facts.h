#pragma once

#include <vector>

#include "engine/core/error.h"
#include "engine/graph/semantics/flat_graph.h"

namespace tactus {

/// Where units, lanes and ranges, once inferred, contradict each other or what a port wants; by place. A
/// mistake in the file of a part that is used twice is told once.
std::vector<Error> check_facts(const FlatGraph& graph);

}  // namespace tactus
