#pragma once
// Thread: [control]

#include <filesystem>
#include <limits>
#include <map>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "engine/core/error.h"
#include "engine/graph/plan/compile.h"

namespace tactus::app {

/// Prints errors on stderr and gives the exit code: of a bad file, or of wrong usage if all come from the
/// command line.
int report(const std::vector<Error>& errors);
int report(const Error& error);

/// The exit code of what a device did not do: a request that it cannot grant is wrong usage.
int exit_of(const Error& error);

/// Why a command ends early, and its exit code. Thrown, as CLI11's errors are: main reports it.
struct CommandError {
  std::vector<Error> errors;
  int exit = 0;  ///< 0: of a bad file, or of wrong usage if all come from the command line
};

/// Ends the command.
[[noreturn]] inline void exit_with(Error error, int exit = 0) {
  throw CommandError{{std::move(error)}, exit};
}

/// The value of a result; its errors end the command.
template <class T>
T or_exit(Result<T> result, int exit = 0) {
  if (!result) exit_with(std::move(result.error()), exit);
  if constexpr (!std::is_void_v<T>) return std::move(*result);
}
template <class T>
T or_exit(Checked<T> result, int exit = 0) {
  if (!result) throw CommandError{std::move(result.error()), exit};
  if constexpr (!std::is_void_v<T>) return std::move(*result);
}

/// A bar on stderr for work that takes longer than a moment; draws nothing when stderr is no terminal.
class Progress {
 public:
  explicit Progress(std::string what);
  ~Progress();
  void operator()(double share);
  /// Shows what is being done, too.
  void operator()(double share, const std::string& what);

 private:
  std::string what_;
  bool shown_ = false;
  bool terminal_;
  int percent_ = -1;
};

/// Warns on stderr when an instrument was never tried with such a system delay.
void announce_delay(const GraphSpec& instrument, double delay_s);

/// Which file a person means: a file, or the `name` (scene.toml, instrument.toml) of a folder.
std::filesystem::path resolve_target(const std::string& target, const char* name);
/// The folder that the parts of a file may not leave: the "instruments" above it, or its own.
std::filesystem::path root_of(const std::filesystem::path& file);

/// "strength=0.5", "sensitivity=-40 dB" → SI. Errors: Syntax.
Result<std::map<std::string, ControlValue>> parse_settings(const std::vector<std::string>& texts);
/// "20 ms" or a bare number in the unit's SI. Errors: Syntax, UnitMismatch.
Result<double> parse_option(const std::string& text, const char* unit, const char* option);
/// --rate. Errors: as parse_option, and OutOfRange below 1 kHz and above 768 kHz.
Result<Hertz> parse_rate(const std::string& text);
/// --delay. Errors: as parse_option, and OutOfRange below 0 s and above 10 s.
Result<Seconds> parse_delay(const std::string& text);
/// --duration. Errors: as parse_option, and OutOfRange at or below 0 s and above `longest`.
Result<Seconds> parse_duration(const std::string& text,
                               Seconds longest = Seconds{std::numeric_limits<double>::infinity()});

}  // namespace tactus::app
