#pragma once
// Thread: [control]

#include <CLI/CLI.hpp>
#include <filesystem>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "apps/cli/printer.h"
#include "engine/core/error.h"
#include "engine/graph/plan/compile.h"

namespace tactus::app {

/// Exit codes of the program.
enum Exit { kDone = 0, kNo = 1, kUsage = 2, kBadFile = 3, kDevice = 4, kInterrupted = 5 };

/// "tactus 0.1.0", as CMakeLists.txt has it.
const char* version();

/// Each command adds itself: its options, its help, and what it does (its result goes into `exit_code`).
void add_play(CLI::App& app, int& exit_code);
void add_list(CLI::App& app, int& exit_code);
void add_actuators(CLI::App& app, int& exit_code);
void add_new(CLI::App& app, int& exit_code);
void add_render(CLI::App& app, int& exit_code);
void add_check(CLI::App& app, int& exit_code);
void add_explain(CLI::App& app, int& exit_code);
void add_export(CLI::App& app, int& exit_code);
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

/// For the whole program, once all commands have added themselves: no option takes an empty text. It names
/// nothing, and some options would take it for their default.
void refuse_empty_texts(CLI::App& app);

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

/// Why a command ends early, and its exit code. Thrown, as CLI11's errors are: main reports it.
struct CommandError {
  std::vector<Error> errors;  ///< none: the user interrupted it
  int exit = 0;               ///< 0: of a bad file, or of wrong usage if all come from the command line
};

/// Prints errors on stderr and gives the exit code; `as_json`: on stdout too, as {"errors": […]}.
int report(const CommandError& error, bool as_json = false);

/// Ends with a suggestion where a word that must be a command is none: "plya", "study wall". Throws a
/// CommandError.
void check_commands(const CLI::App& app, const std::vector<std::string>& words);

/// `what` needs more memory than there is.
Error out_of_memory(const std::string& what);

/// The exit code of what a device did not do: a request that it cannot grant is wrong usage.
int exit_of(const Error& error);

/// Ends the command.
[[noreturn]] inline void exit_with(std::vector<Error> errors, int exit = 0) {
  throw CommandError{std::move(errors), exit};
}
[[noreturn]] inline void exit_with(Error error, int exit = 0) {
  exit_with(std::vector{std::move(error)}, exit);
}

/// The value of a result; its errors end the command.
template <class T, class E>
T or_exit(tl::expected<T, E> result, int exit = 0) {
  if (!result) exit_with(std::move(result.error()), exit);
  if constexpr (!std::is_void_v<T>) return std::move(*result);
}

/// From now on Ctrl-C, SIGTERM and a terminal that is closed only set `interrupted`. For work without
/// outputs: those need a StopLoop.
void install_signal_handlers();
bool interrupted();

/// Prints a line on standard error; errors of writing are ignored.
void print_note(const std::string& text) noexcept;

/// A bar on stderr for work that takes longer than a moment; draws nothing when stderr is no terminal. The
/// work does not wait for the terminal.
class Progress {
 public:
  explicit Progress(std::string what);
  /// `what`: what is being done now; empty: as before.
  void operator()(double share, const std::string& what = {});

 private:
  std::string what_;
  std::optional<Printer> printer_;  ///< where there is a terminal
  int percent_ = -1;
};

/// Empty, or a warning: an instrument was never tried with such a system delay.
std::string delay_warning(const GraphSpec& instrument, double delay_s);
/// The same on stderr.
void announce_delay(const GraphSpec& instrument, double delay_s);

// Options as they are written. Each throws a CommandError.

/// The name and the value of "NAME=VALUE". Errors: Syntax, with `example`.
std::pair<std::string, std::string> parse_assignment(const std::string& text, const char* option,
                                                     const std::string& form, const std::string& example);
/// "strength=0.5", "sensitivity=-40 dB" → SI. Errors: Syntax.
std::map<std::string, ControlValue> parse_settings(const std::vector<std::string>& texts);

inline constexpr double kUnbounded = std::numeric_limits<double>::infinity();
inline constexpr double kAboveZero = std::numeric_limits<double>::min();
/// "20 ms" or a bare number in the unit's SI. Errors, at --option: Syntax, UnitMismatch, OutOfRange.
double parse_option(const std::string& text, const char* unit, const std::string& option,
                    double least = -kUnbounded, double most = kUnbounded);
inline Hertz parse_rate(const std::string& text, const char* option = "rate") {
  return Hertz{parse_option(text, "Hz", option, 1e3, 768e3)};
}
inline Seconds parse_delay(const std::string& text) {
  return Seconds{parse_option(text, "s", "delay", 0, 10)};
}
inline Seconds parse_duration(const std::string& text, Seconds longest = Seconds{kUnbounded}) {
  return Seconds{parse_option(text, "s", "duration", kAboveZero, longest.value)};
}

}  // namespace tactus::app
