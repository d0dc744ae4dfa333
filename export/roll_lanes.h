#pragma once

// Thread: [control].

#include "export/program.h"

namespace tactus {

/// Writes what many lanes or voices do alike once, as a loop: statements that follow each other again and
/// again and differ only in names of variables, members and tables and in numbers. Variables and members
/// become arrays, numbers count up with the loop or become a table. Results stay the same to the bit, since
/// every lane does what it did, in the same order.
void roll_lanes(CProgram& program);

}  // namespace tactus
