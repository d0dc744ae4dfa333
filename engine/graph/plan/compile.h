#pragma once

// Thread: [control].

#include <cstddef>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/core/error.h"
#include "engine/graph/file/load.h"
#include "engine/graph/file/quantity.h"
#include "engine/graph/file/spec.h"
#include "engine/graph/node_type.h"
#include "engine/graph/plan/plan.h"

namespace tactus {

/// What a control is set to; the unit is checked if one was given.
struct ControlValue {
  double si = 0;
  std::optional<Dimension> dimension = {};

  ControlValue() = default;
  ControlValue(double value) : si(value) {}
  ControlValue(double value, Dimension of) : si(value), dimension(of) {}
  ControlValue(const QuantityValue& value) : si(value.si) {
    if (!value.bare) dimension = value.unit.dimension;
  }
};

struct CompileOptions {
  Hertz sample_rate = 48_kHz;
  Seconds system_delay = 0_s;
  /// What a graph may unfold to and keep: a short file with parts and voices can ask for anything.
  std::size_t most_nodes = 250'000;  ///< nodes and operators, those of each lane on their own
  std::size_t most_bytes = 512u << 20;
  /// Start values of controls in place of those of the file, SI.
  std::map<std::string, ControlValue> controls;
  /// Signals that become outputs of their own ("hit", "hit.level"), for events, scopes and recordings.
  std::vector<std::string> taps;
  /// What lies outside answers within the same frame: every output must then be ready before any input is
  /// read, and the plan has one `Outside` step between the two.
  bool closed_outside = false;
  /// Eight lanes of the same thing run as one vector (see `vectorise`). Off, each runs on its own: to
  /// compare.
  bool vectorise = true;
};

/// The errors found before any node is made, in file order: names, ports, settings, units, lanes,
/// ranges.
std::vector<Error> check(const GraphSpec& spec, const NodeTable& table, const CompileOptions& options);

/// resolve → unfold lanes → prune and fold → make the nodes → vectorise → plan. Errors, in
/// file order: those of `check`; without any, those of making the nodes, and all loops without a
/// delay.
Checked<std::unique_ptr<Plan>> compile(const GraphSpec& spec, const NodeTable& table,
                                       const CompileOptions& options);

/// The same for a graph just loaded: the errors of its text and those of `check` together.
Checked<std::unique_ptr<Plan>> compile(const LoadedGraph& graph, const NodeTable& table,
                                       const CompileOptions& options);

}  // namespace tactus
