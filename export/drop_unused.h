#pragma once

// Thread: [control].

#include "export/program.h"

namespace tactus {

/// Leaves out variables of a frame that nothing reads: a node may ignore an input. What changes a state
/// stays.
void drop_unused(CProgram& program);

}  // namespace tactus
