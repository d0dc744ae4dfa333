#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "apps/cli/commands.h"
#include "apps/cli/console.h"
#include "apps/study/reports.h"
#include "apps/study/sweep_options.h"
#include "engine/nodes/table.h"

namespace tactus::app {
namespace {

struct PlayabilityArguments : SweepOptions {
  std::string delay = "0:40:1 ms";
};

Result<std::vector<double>> delays_of(const std::string& text) {
  const auto values = parse_steps(text, "--delay");
  if (!values) return tl::unexpected(values.error());
  std::vector<double> delays;
  for (const auto& value : *values) {
    if (!value.dimension || !(*value.dimension == Dimension{.second = 1}))
      return fail(Errc::UnitMismatch, "--delay", "'" + text + "' is not a time or a range of times",
                  "write for instance \"0:40:1 ms\"");
    if (value.si < 0 || value.si > 1)
      return fail(Errc::OutOfRange, "--delay", "a delay of " + fmt::format("{:g} s", value.si),
                  "choose 0 s to 1 s");
    delays.push_back(value.si);
  }
  return delays;
}

Result<PlayabilityOptions> study_options(const PlayabilityArguments& options, SceneSpec& scene) {
  if (options.over.size() > 2)
    return fail(Errc::BadArgument, "--over", "at most two parameters can be swept in addition to the delay",
                "use tactus sweep for more");
  auto plan = read_plan(options, scene);
  if (!plan) return tl::unexpected(plan.error());
  const double least_s = scene.playability ? scene.playability->from_s + 1 : 1;
  if (!options.duration.empty() && scene.duration.value < least_s)
    return fail(Errc::OutOfRange, "--duration", "leaves less than one second to evaluate",
                fmt::format("choose at least {:g} s", least_s));
  for (const auto& swept : plan->over)
    if (swept.what == SweptValue::What::Delay)
      return fail(Errc::BadArgument, "--over", "the delay is swept already", "use --delay");
  auto delays = delays_of(options.delay);
  if (!delays) return tl::unexpected(delays.error());
  return PlayabilityOptions{std::move(*plan), std::move(*delays)};
}

int run_playability(const PlayabilityArguments& options) {
  auto scene = load_target(options);
  if (!scene) return report(scene.error());
  auto plan = study_options(options, *scene);
  if (!plan) return report(plan.error()), kUsage;
  SweepMonitor monitor{scene->name, *plan};
  const auto study = study_playability(*scene, standard_nodes(), *plan);
  if (!study) return report(study.error());
  if (const auto exit = monitor.end(finished(study->runs), std::ssize(study->runs))) return *exit;
  if (const int failed = publish(options, app::text_of(*study), app::json_of(*study), plots_of(*study),
                                 study->over.size() > 1 ? 2 : 1))
    return failed;
  const auto verdicts = study->verdicts();
  const bool playable =
      std::all_of(verdicts.begin(), verdicts.end(), [](const auto& v) { return v.playable; });
  return playable ? kDone : kNo;
}

}  // namespace

void add_study_playability(CLI::App& study, int& exit_code) {
  auto* command = study.add_subcommand("playability", "Playability of a scene as a function of the delay");
  auto options = std::make_shared<PlayabilityArguments>();
  add_study_options(*command, *options, "scene with [playability]; for a folder, its scene.toml")->required();
  command->add_option("--delay", options->delay, "delays to simulate: FROM:TO:STEP, or a single value")
      ->capture_default_str();
  add_sweep_options(*command, *options);
  command->footer(
      "Examples:\n  tactus study playability instruments/haptic_drum\n"
      "  tactus study playability instruments/haptic_drum --over strength=0.2:1:5 --svg drum.svg\n"
      "  tactus study playability instruments/haptic_drum --delay \"20 ms\" --gain \"6 dB\" --draws 50\n"
      "  tactus study playability instruments/cellomobo/open_string.toml --delay \"0:40:5 ms\" --over "
      "\"tuned=55:880:5:log Hz\"\n"
      "The criteria are in [playability] of the scene; see docs/playability.md.\n"
      "Exit code 1: not playable at one or more delays. 5: interrupted.");
  command->callback([options, &exit_code] { exit_code = run_playability(*options); });
}

}  // namespace tactus::app
