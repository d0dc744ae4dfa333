#pragma once

// Thread: [control].

#include <cstddef>
#include <span>

#include "export/program.h"

namespace tactus {

/// How a machine stores what C programs consist of, in bytes.
struct MachineType {
  const char* name;
  std::size_t of_int, of_long, of_pointer, of_enum, of_double;
  std::size_t most_alignment;
};

/// [any] Machines whose memory READMEs name.
std::span<const MachineType> machine_types();

/// sizeof of the whole program, with its own number type.
std::size_t state_bytes(const CProgram& program, const MachineType& machine);

}  // namespace tactus
