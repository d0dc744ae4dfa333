#pragma once

// Thread: [control].

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "engine/core/error.h"
#include "engine/graph/file/load.h"
#include "engine/graph/node_type.h"
#include "engine/graph/plan/compile.h"
#include "engine/guard/guarded.h"
#include "export/fixed/fixed_program.h"
#include "export/program.h"
#include "export/targets/target.h"

namespace tactus {

struct ExportOptions {
  const ExportTarget* target = nullptr;
  const NumberType* number = nullptr;
  RecurrenceForm recurrence = RecurrenceForm::Grid;
  Hertz sample_rate = 48_kHz;
  Seconds system_delay = 0_s;
  /// The limits of an output; empty: the program has no guard.
  std::function<GuardedChannel(const OutputChannel&)> limits = {};
  std::string limits_from = {};                       ///< for people
  std::optional<std::size_t> most_bytes = {};         ///< of the state
  std::map<std::string, ControlValue> controls = {};  ///< start values in place of those of the file
};

/// A graph as C. Errors: those of `compile`; BadArgument for each node that cannot be exported, all at once.
Checked<CProgram> write_program(const LoadedGraph& graph, const NodeTable& nodes,
                                const ExportOptions& options);

/// A graph as C in integers. Errors: those of `compile` and of `read_fixed`.
Checked<FixedProgram> write_fixed_program(const LoadedGraph& graph, const NodeTable& nodes,
                                          const ExportOptions& options);

/// The files that a target makes of it.
Checked<std::vector<ExportedFile>> export_graph(const LoadedGraph& graph, const NodeTable& nodes,
                                                const ExportOptions& options);

}  // namespace tactus
