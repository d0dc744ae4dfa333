#include <fmt/format.h>

#include "apps/check/check_report.h"
#include "apps/cli/commands.h"
#include "apps/cli/console.h"
#include "engine/core/index.h"
#include "engine/graph/file/read_graph.h"
#include "engine/nodes/table.h"
#include "engine/rig/rig.h"
#include "engine/study/sweep/evaluate_runs.h"

namespace tactus::app {
namespace {

struct CheckOptions {
  std::string target, rate, delay, rig;
  std::string hand_damping = "2 N s/m", hand_mass = "6 g", push = "10 N";
  std::string device_mass = "50 g", device_damping = "0.1 N s/m";
  std::vector<std::string> set;
  bool quick = false, json = false, verbose = false;
};

/// The scene or the instrument to check, and how.
struct CheckJob {
  std::optional<LoadedScene> scene;
  std::optional<LoadedGraph> instrument;
  StabilityOptions options;

  StabilitySubject subject() const {
    return {scene ? &*scene : nullptr, instrument ? &*instrument : nullptr, &standard_nodes()};
  }
};

std::filesystem::path file_of(const CheckOptions& options) {
  const auto scene = resolve_target(options.target, "scene.toml");
  const bool none = std::filesystem::is_directory(options.target) && !std::filesystem::exists(scene);
  return options.rig.empty() && !none ? scene : resolve_target(options.target, "instrument.toml");
}

/// Gives its name.
std::string load(const CheckOptions& options, CheckJob& job) {
  const auto file = file_of(options);
  const auto table = or_exit(load_toml(file), kBadFile);
  if (find(table, "parts") != nullptr) {
    job.scene = load_scene_leniently(file, root_of(file));
    if (!job.scene->scene) throw CommandError{job.scene->mistakes, kBadFile};
    return job.scene->scene->name;
  }
  job.instrument = load_graph_leniently(file, root_of(file));
  if (job.instrument->spec == nullptr) throw CommandError{job.instrument->errors, kBadFile};
  return job.instrument->spec->name;
}

double above_zero(const std::string& text, const char* unit, const char* option) {
  const double value = or_exit(parse_option(text, unit, option), kUsage);
  if (!(value > 0)) exit_with({Errc::OutOfRange, std::string{"--"} + option, "must be above 0", ""}, kUsage);
  return value;
}

/// --delay, else the scene's, else the measured one of the rig, else the longest of what was tested. Gives
/// its source.
std::string choose_delay(const CheckOptions& options, CheckJob& job) {
  auto& world = job.options.world;
  if (!options.delay.empty()) {
    world.delay = or_exit(parse_delay(options.delay), kUsage);
    return "delay as asked for";
  }
  if (job.scene) {
    world.delay = job.scene->scene->delay;
    return "delay of the scene";
  }
  if (!options.rig.empty()) {
    const auto rig = or_exit(load_rig(options.rig, root_of(options.rig)), kBadFile);
    if (!rig.measured_delay)
      exit_with({Errc::Missing, options.rig, "this rig has no measured delay",
                 "measure it with 'tactus latency measure --rig " + options.rig + "', or give --delay"},
                kBadFile);
    world.delay = *rig.measured_delay;
    for (const auto& control : rig.controls)
      world.set.try_emplace(control.name, ControlValue{control.value.si});
    return "delay as measured on the rig";
  }
  const auto tested = tested_delays(*job.instrument->spec);
  if (!tested) return "no delay is known";
  world.delay = Seconds{tested->high};
  return "longest delay that it was tested with";
}

/// Gives the source of the delay.
std::string read_options(const CheckOptions& options, CheckJob& job) {
  auto& world = job.options.world;
  if (!options.rate.empty()) world.rate = or_exit(parse_rate(options.rate), kUsage);
  job.options.hand = {above_zero(options.hand_damping, "N s/m", "hand-damping"),
                      above_zero(options.hand_mass, "kg", "hand-mass")};
  world.device = {above_zero(options.device_mass, "kg", "device-mass"),
                  above_zero(options.device_damping, "N s/m", "device-damping")};
  job.options.push = above_zero(options.push, "N", "push");
  world.set = or_exit(parse_settings(options.set), kUsage);
  return choose_delay(options, job);
}

/// Predicts whether it is stable where the run takes it, and measures it there.
Checked<ExtremeRun> predict_and_run(const CheckJob& job, ExtremePlan plan) {
  if (!plan.linear) plan.expected = is_stable_with(job.subject(), plan.world, job.options.push);
  return run_extreme(job.subject(), plan);
}

/// On all processors.
std::vector<ExtremeRun> run_all(const CheckJob& job, const StabilityVerdict& verdict) {
  const auto world = or_exit(RestingWorld::make(job.subject(), job.options.world));
  auto plans = border_runs(job.options.world, verdict);
  for (auto& plan : extremes_of(job.options.world, world.instrument())) plans.push_back(std::move(plan));
  std::vector<Checked<ExtremeRun>> made(plans.size());
  Progress progress{"running"};
  parallel_for(
      static_cast<int>(plans.size()), [&](int i) { made[index(i)] = predict_and_run(job, plans[index(i)]); },
      [&](double share) { progress(share); });
  std::vector<ExtremeRun> runs;
  for (auto& run : made) runs.push_back(or_exit(std::move(run)));
  exclude_player_energy(runs);
  return runs;
}

StabilityVerdict analyse(const CheckJob& job) {
  Progress progress{"analysing the loops"};
  return or_exit(analyse_stability(job.subject(), job.options, [&](double share) { progress(share); }));
}

int run_check(const CheckOptions& options) {
  CheckJob job;
  CheckReport report;
  report.name = load(options, job);
  report.delay_source = read_options(options, job);
  report.verdict = analyse(job);
  if (!options.quick) report.runs = run_all(job, report.verdict);
  if (options.json)
    fmt::print("{}\n", json_of(report).dump(2));
  else
    print(report, options.verbose);
  return report.passed() ? kDone : kNo;
}

}  // namespace

void add_check(CLI::App& app, int& exit_code) {
  auto* command =
      app.add_subcommand("check", "Whether an instrument or scene is stable, and what would break first");
  auto options = std::make_shared<CheckOptions>();
  command
      ->add_option("FILE", options->target,
                   "instrument or scene; a folder means its scene.toml, with --rig its instrument.toml")
      ->required();
  command->add_option("--rate", options->rate, "sample rate, instead of the scene's or 48 kHz");
  command->add_option("--delay", options->delay, "system delay, instead of the scene's or the rig's");
  command->add_option("--rig", options->rig, "rig file: its measured delay");
  command->add_option("--set", options->set, "NAME=VALUE of a control");
  for (const auto& [name, value, help] :
       {std::tuple{"--hand-damping", &options->hand_damping, "added to the device by a fingertip"},
        {"--hand-mass", &options->hand_mass, "added to the device by a fingertip"},
        {"--push", &options->push, "force in contacts that are analysed closed"},
        {"--device-mass", &options->device_mass, "of the device that an instrument without a scene pushes"},
        {"--device-damping", &options->device_damping, "of that device"}})
    command->add_option(name, *value, help)->capture_default_str();
  command->add_flag("--quick", options->quick, "only the analysis of the graph, without the runs");
  command->add_flag("--verbose", options->verbose, "every loop, network, control and run as a table");
  command->add_flag("--json", options->json, "every number, for machines");
  command->footer(
      "Examples:\n  tactus check instruments/haptic_drum\n  tactus check my_wall.toml --delay \"1 ms\" "
      "--device-mass \"30 g\"\n  tactus check my_scene.toml --quick --json\n\nExit code 1: it is "
      "unstable.");
  command->callback([options, &exit_code] { exit_code = run_check(*options); });
}

}  // namespace tactus::app
