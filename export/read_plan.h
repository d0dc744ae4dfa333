#pragma once

// Thread: [control].

#include "engine/graph/plan/plan.h"
#include "export/program.h"
#include "export/recorded_nodes.h"

namespace tactus {

/// Fills a program with what a plan computes: members of the state and statements. The plan was compiled with
/// the table of `nodes`, without vectorisation and with the system delay of the program. Errors: BadArgument
/// for each node that cannot be exported, all at once.
Checked<CProgram> read_plan(CProgram program, const Plan& plan, const RecordedNodes& nodes);

}  // namespace tactus
