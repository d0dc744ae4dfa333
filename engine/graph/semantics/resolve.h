#pragma once

// Thread: [control].

#include <cstddef>
#include <string>
#include <vector>

#include "engine/core/error.h"
#include "engine/graph/file/spec.h"
#include "engine/graph/node_table.h"
#include "engine/graph/semantics/flat_graph.h"

namespace tactus {

struct Resolved {
  FlatGraph graph;  ///< FlatSignal::Kind::Missing replaces what is missing
  std::vector<Error> mistakes;
  bool too_large = false;  ///< parts were left out, with an error: the graph has more than `most_signals`
};

/// Looks every name up: node types, ports, settings, signals; unfolds parts. `taps` names signals of the top
/// file ("hit", "hit.level") that become outputs of their own.
Resolved resolve(const GraphSpec& spec, const NodeTable& table, Hertz sample_rate,
                 const std::vector<std::string>& taps = {}, std::size_t most_signals = 1'000'000);

}  // namespace tactus
