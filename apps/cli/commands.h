#pragma once
// Thread: [control]

#include <CLI/CLI.hpp>
#include <memory>
#include <utility>

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

/// A subcommand, and the options that `run` gets when it is called; what it returns is the exit code.
template <class Options>
std::pair<CLI::App&, Options&> add_command(CLI::App& parent, const char* name, const char* help,
                                           int& exit_code, int (*run)(const Options&)) {
  auto options = std::make_shared<Options>();
  auto* command = parent.add_subcommand(name, help);
  command->callback([options, run, &exit_code] { exit_code = run(*options); });
  return {*command, *options};
}
/// A subcommand of subcommands. Without one of them it prints its help.
CLI::App& add_command_group(CLI::App& app, const char* name, const char* help, const char* footer);

/// A number from `low` to `high`, or several; the help shows its default.
template <class Number, class Bound>
CLI::Option* add_number(CLI::App& command, const char* name, Number& value, const char* help, Bound low,
                        Bound high) {
  return command.add_option(name, value, help)->check(CLI::Range(low, high))->capture_default_str();
}

/// Whether a file can be written there, or files into that folder, which may still be missing: known when the
/// command line is read, before the work whose result goes there. Leaves everything as it was.
CLI::Validator writable_file();
CLI::Validator writable_folder();

}  // namespace tactus::app
