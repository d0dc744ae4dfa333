#pragma once

#include <vector>

#include "engine/core/error.h"
#include "engine/graph/semantics/flat_graph.h"

namespace tactus {

/// Works out and checks the unit, the number of lanes and the range of every signal, loops included, and
/// fills them in. Each fact starts as "unknown" and passes are made until nothing changes; ranges start
/// unbounded and only shrink, so they hold at every pass. Returns the mistakes, in file order.
std::vector<Error> infer(FlatGraph& graph);

}  // namespace tactus
