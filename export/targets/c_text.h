#pragma once

// Thread: [control].

#include <string>
#include <vector>

#include "export/program.h"

namespace tactus {

/// The parts of a program as C text with its own names and numbers. Every target writes these two.
std::string c_header(const CProgram& program);
std::string c_source(const CProgram& program);

/// Text of kernels with the names and the numbers of a program: tactus_x is haptic_drum_x.
std::string as_of_program(const std::string& text, const CProgram& program);

/// "HAPTIC_DRUM" of "haptic_drum".
std::string in_capitals(std::string text);
/// Statements, each a line or several, indented.
std::string indented(const std::vector<std::string>& statements, int spaces);

/// A line that is too long, broken at spaces; further lines are indented by four more.
std::string wrapped(const std::string& line);

/// Between a ceiling and the number below it. 0 of doubles: they give the bits of the engine.
double spacing_below(double ceiling, const NumberType& type);

/// Of an output.
bool has_slew_limit(const GuardedChannel& channel);

/// The types of the header, each declaration without comments, behind those that it uses; the last one is the
/// whole program, "tactus".
std::vector<std::string> type_declarations(const CProgram& program);

/// What stands in every header in front of its types, and behind them.
struct HeaderCounts {
  std::size_t inputs, outputs, controls;
};
std::string header_begin(const HeaderCounts& counts, Hertz rate, const std::string& includes);
std::string header_end(const std::string& about_step);

/// For people: the limits of the outputs, and what can no longer be set. Markdown.
std::string limits_section(const CProgram& program);
std::string fixed_section(const CProgram& program);

}  // namespace tactus
