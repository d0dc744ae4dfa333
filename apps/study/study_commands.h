#pragma once

#include <CLI/CLI.hpp>

namespace tactus::app {

// Each adds itself below `tactus study`.
void add_study_work_precision(CLI::App& study, int& exit_code);
void add_study_stability(CLI::App& study, int& exit_code);
void add_study_playability(CLI::App& study, int& exit_code);
void add_study_bifurcation(CLI::App& study, int& exit_code);

}  // namespace tactus::app
