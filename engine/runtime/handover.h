#pragma once

#include "engine/core/error.h"
#include "engine/runtime/running.h"

namespace tactus {

/// [control] Fills in what `after` takes over from `before`, which may be running meanwhile:
///  - A node of the same path and made from the same things goes on with its state.
///  - A control keeps its value and its number; one whose value in the file is another moves there.
///  - A constant that differs at a place that is otherwise the same moves from the old number to the new.
///  - An output jumps if a step that feeds it, directly or through others, is new, was made anew, or reads
///    something else. What differs in constants alone does not jump.
/// Errors: BadArgument if sample rate, inputs, outputs or taps are not the same.
[[nodiscard]] Status plan_handover(const Running& before, Running& after);

}  // namespace tactus
