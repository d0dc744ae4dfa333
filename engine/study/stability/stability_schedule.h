#pragma once

#include <string>
#include <vector>

#include "engine/graph/plan/schedule.h"
#include "engine/study/stability/models/stability_graph.h"

namespace tactus {

/// Where a schedule meets the outside: its signals in the graph, -1 for what is not read or rests.
struct Terminals {
  std::vector<int> inputs;    ///< in the order of Schedule::input_names
  std::vector<int> channels;  ///< in the order of Schedule::channels, taps included
};

/// [control] Adds a schedule (compiled with `side_by_side` off) as it is at the place where its signals
/// stand: it must have run, and last for one frame. `prefix` comes before its names.
Terminals add_schedule(LinearGraph& graph, const Schedule& schedule, const Regime& regime,
                       const std::string& prefix);

}  // namespace tactus
