#pragma once

// Thread: [control].

#include <string>
#include <vector>

#include "engine/graph/plan/plan.h"
#include "engine/study/stability/models/stability_graph.h"

namespace tactus {

/// Where a plan meets the outside: its signals in the graph, -1 for what is not read or rests.
struct Terminals {
  std::vector<int> inputs;    ///< in the order of Plan::input_names
  std::vector<int> channels;  ///< in the order of Plan::channels, taps included
};

/// [control] Adds a plan (compiled with `vectorise` off) at the operating point where its signals
/// stand: it must have run, and last for one frame. `prefix` comes before its names.
Terminals add_plan(LinearGraph& graph, const Plan& plan, const Regime& regime, const std::string& prefix);

}  // namespace tactus
