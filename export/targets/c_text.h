#pragma once

// Thread: [control].

#include <string>

#include "export/program.h"

namespace tactus {

/// The parts of a program as C text with its own names and numbers. Every target writes these two.
std::string c_header(const CProgram& program);
std::string c_source(const CProgram& program);

/// Text of kernels with the names and the numbers of a program: tactus_x is haptic_drum_x.
std::string as_of_program(const std::string& text, const CProgram& program);

/// A line that is too long, broken at spaces; further lines are indented by four more.
std::string wrapped(const std::string& line);

/// Bytes of the state and of constants, as on a machine of 64 bits.
std::size_t state_bytes(const CProgram& program);

}  // namespace tactus
