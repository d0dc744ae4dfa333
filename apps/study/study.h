#pragma once
// Thread: [control]

#include <optional>
#include <string>
#include <vector>

#include "apps/cli/console.h"
#include "apps/cli/json.h"
#include "engine/plot/plot.h"
#include "engine/study/orbits/bifurcation.h"
#include "engine/study/playability/playability.h"
#include "engine/study/sweep/sweep.h"
#include "engine/study/walls/wall_map.h"
#include "engine/study/work_precision/work_precision.h"

namespace tactus::app {

/// Text in columns of equal width, aligned to the right; the first row is the head.
struct Table {
  std::vector<std::vector<std::string>> rows;

  std::string text() const;
  /// The same as a table of Markdown.
  std::string markdown() const;
};

// Reports of complete studies as text, JSON and plots.

std::string text_of(const Bifurcation& study);
Json json_of(const Bifurcation& study);
std::vector<Plot> plots_of(const Bifurcation& study);

/// A row per setting: swept values, then measures.
std::string text_of(const SweepTable& table);
Json json_of(const SweepTable& table);

/// One line per delay: score, kind, measures; if something is swept, also maps of letters; the verdict.
std::string text_of(const PlayabilityStudy& study);
Json json_of(const PlayabilityStudy& study);
/// "playable from 0 to 40 ms; weakest at 23 ms: irregular, score 0.61"
std::string describe_verdict(const PlayabilityStudy& study);

/// The largest stiffness over the delay, over the rate, and of each controller.
std::string text_of(const WallMap& map);
Json json_of(const WallMap& map);
std::vector<Plot> plots_of(const WallMap& map);

/// One line per variant, by computing time; the references of the errors; the cheapest variants for 1 % and
/// for 0.01 %.
std::string text_of(const WorkPrecision& study);
/// The variants as a table of Markdown.
std::string markdown_of(const WorkPrecision& study);
/// A line for each rate: what `auto` chose there, and its cost beside that of the cheapest.
std::string describe_choices(const WorkPrecision& study);
Json json_of(const WorkPrecision& study);

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
  std::string target, picture, part, cache;
  bool json = false;
  int workers = 0;
};
/// SCENE, --svg, --json, --keep, --part and --workers. `scene`: the help of SCENE.
CLI::Option* add_study_options(CLI::App& command, StudyOptions& options, const std::string& scene);
/// The scene of --target, or the scene.toml of that folder. Throws a CommandError.
SceneSpec load_target(const StudyOptions& options);
/// Throws a CommandError: Syntax, Missing.
void read_run_plan(const StudyOptions& options, RunPlan& plan);
/// Prints a report, as JSON with --json, and writes its plots to --svg. Throws a CommandError.
void publish(const StudyOptions& options, const std::string& text, const Json& json,
             const std::vector<Plot>& page, int columns = 1);

/// Options of every sweep of a scene.
struct SweepOptions : StudyOptions {
  SweepPlan plan;
  std::string gain, within = "20 %", duration;
  std::vector<std::string> over, set;
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
