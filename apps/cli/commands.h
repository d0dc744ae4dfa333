#pragma once
// Thread: [control]

#include <CLI/CLI.hpp>

namespace tactus::app {

/// Exit codes of the program.
enum Exit { kDone = 0, kNo = 1, kUsage = 2, kBadFile = 3, kDevice = 4, kInterrupted = 5 };

/// "tactus 0.1.0", as CMakeLists.txt has it.
const char* version();

/// Each command adds itself: its options, its help, and what it does (its result goes into `exit_code`).
void add_play(CLI::App& app, int& exit_code);
void add_render(CLI::App& app, int& exit_code);
void add_check(CLI::App& app, int& exit_code);
void add_explain(CLI::App& app, int& exit_code);
void add_study(CLI::App& app, int& exit_code);
void add_sweep(CLI::App& app, int& exit_code);
void add_nodes(CLI::App& app, int& exit_code);
void add_devices(CLI::App& app, int& exit_code);
void add_doctor(CLI::App& app, int& exit_code);
void add_latency(CLI::App& app, int& exit_code);

}  // namespace tactus::app
