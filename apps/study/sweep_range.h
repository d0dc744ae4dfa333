#pragma once

#include <string>
#include <vector>

#include "engine/core/error.h"
#include "engine/graph/plan/compile.h"

namespace tactus::app {

/// What a sweep goes through, evenly in the unit that it is written in (decibels in decibels). A bare number
/// takes the unit of another one: "0:40:1 ms", "-12:0 dB:5".
///
/// "FROM:TO:STEP"; TO is in it when steps lead there. Errors, at `option`: Syntax, OutOfRange.
Result<std::vector<ControlValue>> parse_steps(const std::string& text, const std::string& option);
/// "FROM:TO:COUNT"; a single value is "FROM". "FROM:TO:COUNT:log" goes up by equal factors, as bow force and
/// speed do in Schelleng's diagram and notes on a scale; both ends have one sign, and are not 0.
Result<std::vector<ControlValue>> parse_spread(const std::string& text, const std::string& option);

}  // namespace tactus::app
