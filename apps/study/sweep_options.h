#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

#include "apps/cli/console.h"
#include "apps/study/reports.h"
#include "engine/study/sweep/sweep.h"

// Thread: [control]

namespace tactus::app {

/// The values of a sweep, equally spaced in the unit that they are written in (decibels in decibels). A bare
/// number takes the unit of another one: "0:40:1 ms", "-12:0 dB:5".
///
/// "FROM:TO:STEP"; TO is included when steps lead there. Throw a CommandError, at `option`: Syntax,
/// UnitMismatch, OutOfRange.
std::vector<ControlValue> parse_steps(const std::string& text, const std::string& option);
/// "FROM:TO:COUNT"; a single value is "FROM". "FROM:TO:COUNT:log" grows by equal factors; both ends have one
/// sign, and are not 0.
std::vector<ControlValue> parse_spread(const std::string& text, const std::string& option);

// Each adds itself below `tactus study`.
void add_study_work_precision(CLI::App& study, int& exit_code);
void add_study_stability(CLI::App& study, int& exit_code);
void add_study_playability(CLI::App& study, int& exit_code);
void add_study_bifurcation(CLI::App& study, int& exit_code);

/// Reads a quantity such as "9 g" of --name into `value`, if it is given. Throws a CommandError.
inline void read_option(const std::string& text, const char* unit, const char* name, double least,
                        double most, double& value) {
  if (!text.empty()) value = parse_option(text, unit, name, least, most);
}

/// Options of every study.
struct StudyOptions {
  std::string target, picture;
  bool json = false;
};
/// SCENE, --svg (also --report) and --json. `scene`: the help of SCENE.
CLI::Option* add_study_options(CLI::App& command, StudyOptions& options, const std::string& scene);
/// The scene of --target, or the scene.toml of that folder. Throws a CommandError.
SceneSpec load_target(const StudyOptions& options);
/// Prints a report, as JSON with --json, and writes its plots to --svg. Throws a CommandError.
void publish(const StudyOptions& options, const std::string& text, const Json& json,
             const std::vector<Plot>& page, int columns = 1);
template <class Study>
void publish(const StudyOptions& options, const Study& study, int columns = 1) {
  publish(options, text_of(study), json_of(study), plots_of(study), columns);
}

/// Options of studies that execute many runs.
struct RunOptions : StudyOptions {
  std::string part, cache;
  int workers = 0;
};
/// --keep, --part, --workers.
void add_run_options(CLI::App& command, RunOptions& options);
/// Throws a CommandError: Syntax, Missing.
void read_run_plan(const RunOptions& options, RunPlan& plan);

/// Options of every sweep of a scene.
struct SweepOptions : RunOptions {
  std::string gain, within = "20 %", duration;
  std::vector<std::string> over, set;
  int draws = 0;
  std::uint64_t seed = 1;
};
void add_sweep_options(CLI::App& command, SweepOptions& options);

/// The plan that they describe; --duration changes the scene. Throws a CommandError: Syntax, UnknownName,
/// UnitMismatch, OutOfRange, BadArgument, Missing.
SweepPlan read_plan(const SweepOptions& options, SceneSpec& scene);

/// Progress with the remaining time, and the end by Ctrl-C, for a plan.
class SweepMonitor {
 public:
  SweepMonitor(const std::string& name, RunPlan& plan);
  /// Ends the progress bar. The exit code if the runs are not all of the sweep, with a message.
  std::optional<int> end(std::ptrdiff_t finished, std::ptrdiff_t runs);

 private:
  const RunPlan& plan_;
  std::optional<Progress> progress_;
};

}  // namespace tactus::app
