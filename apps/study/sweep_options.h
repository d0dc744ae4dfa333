#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

#include "apps/cli/console.h"
#include "engine/study/sweep/sweep.h"

// Thread: [control]

namespace tactus::app {

/// The values of a sweep, equally spaced in the unit that they are written in (decibels in decibels). A bare
/// number takes the unit of another one: "0:40:1 ms", "-12:0 dB:5".
///
/// "FROM:TO:STEP"; TO is included when steps lead there. Errors, at `option`: Syntax, OutOfRange.
Result<std::vector<ControlValue>> parse_steps(const std::string& text, const std::string& option);
/// "FROM:TO:COUNT"; a single value is "FROM". "FROM:TO:COUNT:log" grows by equal factors; both ends have one
/// sign, and are not 0.
Result<std::vector<ControlValue>> parse_spread(const std::string& text, const std::string& option);

/// Options that every sweep of a scene has.
struct SweepOptions {
  std::string target, gain, within = "20 %", duration, part, cache, picture;
  std::vector<std::string> over, set;
  int draws = 0, workers = 0;
  std::uint64_t seed = 1;
  bool json = false;
};
void add_sweep_options(CLI::App& command, SweepOptions& options);

/// The plan that they describe; --duration changes the scene. Errors: Syntax, UnknownName, UnitMismatch,
/// OutOfRange, BadArgument, Missing.
Result<SweepPlan> read_plan(const SweepOptions& options, SceneSpec& scene);

/// Progress with the remaining time, and the end by Ctrl-C, for a plan.
class SweepMonitor {
 public:
  SweepMonitor(const SceneSpec& scene, SweepPlan& plan);
  /// Ends the progress bar. The exit code if the runs are not all of the sweep, with a message.
  std::optional<int> end(std::ptrdiff_t finished, std::size_t runs);

 private:
  const SweepPlan& plan_;
  std::optional<Progress> progress_;
};

}  // namespace tactus::app
