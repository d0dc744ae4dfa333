#pragma once

#include <CLI/CLI.hpp>

namespace tactus::app {

void add_study_stability(CLI::App& study, int& exit_code);

}  // namespace tactus::app
