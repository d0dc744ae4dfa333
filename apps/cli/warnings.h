#pragma once

// Thread: [control]

#include <string>

#include "engine/graph/plan/plan.h"

namespace tactus::app {

/// "warning: file:line:column: what; remedy", a line each; "" without warnings.
std::string text_of_warnings(const Plan& plan);
std::string text_of_warning(const Error& warning);

/// The same on standard error.
void print_warnings(const Plan& plan);

}  // namespace tactus::app
