#pragma once

// Thread: [control].

#include "export/program.h"

namespace tactus {

/// Makes one loop of loops over the same lanes that follow each other, where no lane needs what another one
/// does: what goes from one to the next then stays in registers. Every lane does what it did, in the same
/// order. `in` and `out` may still be the same array.
void merge_loops(CProgram& program);

}  // namespace tactus
