#include <fmt/format.h>

#include <atomic>
#include <future>
#include <thread>

#include "apps/check/check_report.h"
#include "apps/cli/commands.h"
#include "apps/cli/console.h"
#include "engine/graph/file/read_graph.h"
#include "engine/nodes/table.h"
#include "engine/rig/rig.h"

namespace tactus::app {
namespace {

struct CheckOptions {
  std::string target, rate, delay, rig;
  std::string hand_damping = "2 N s/m", hand_mass = "6 g", push = "10 N";
  std::string device_mass = "50 g", device_damping = "0.1 N s/m";
  std::vector<std::string> set;
  bool quick = false, json = false, verbose = false;
};

/// What was asked for, with everything loaded.
struct CheckJob {
  CheckedSubject names;
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

/// Reads options that are quantities; the first mistake stays.
class Quantities {
 public:
  std::optional<double> operator()(const std::string& text, const char* unit, const char* option) {
    if (text.empty()) return std::nullopt;
    const auto value = parse_option(text, unit, option);
    if (value) return *value;
    if (!wrong) wrong = value.error();
    return std::nullopt;
  }
  double above_zero(const std::string& text, const char* unit, const char* option) {
    const double value = (*this)(text, unit, option).value_or(1);
    if (!(value > 0) && !wrong)
      wrong = Error{Errc::OutOfRange, std::string{"--"} + option, "must be above 0", ""};
    return value;
  }
  std::optional<Error> wrong;
};

/// --delay, else the scene's, else the measured one of the rig, else the end of what was tested.
std::optional<Refusal> choose_delay(const CheckOptions& options, std::optional<double> asked, CheckJob& job) {
  auto& delay = job.options.world.delay;
  if (asked) {
    delay = Seconds{*asked};
    job.names.delay_from = "delay as asked for";
  } else if (job.scene) {
    delay = job.scene->scene->delay;
    job.names.delay_from = "delay of the scene";
  } else if (!options.rig.empty()) {
    const auto rig = load_rig(options.rig, root_of(options.rig));
    if (!rig) return Refusal{rig.error(), kBadFile};
    if (!rig->measured_delay)
      return Refusal{
          {{Errc::Missing, options.rig, "this rig keeps no measured delay",
            "measure it with 'tactus latency measure --rig " + options.rig + "', or give --delay"}},
          kBadFile};
    delay = *rig->measured_delay;
    for (const auto& control : rig->controls)
      job.options.world.set.try_emplace(control.name, ControlValue{control.value.si});
    job.names.delay_from = "delay as measured on the rig";
  } else if (const auto tested = tested_delays(*job.instrument->spec)) {
    delay = Seconds{tested->high};
    job.names.delay_from = "longest delay that it was tested with";
  } else {
    job.names.delay_from = "no delay is known";
  }
  return std::nullopt;
}

std::optional<Refusal> load(const CheckOptions& options, CheckJob& job) {
  const auto file = file_of(options);
  const auto table = load_toml(file);
  if (!table) return Refusal{{table.error()}, kBadFile};
  if (find(*table, "parts") != nullptr) {
    job.scene = load_scene_leniently(file, root_of(file));
    if (!job.scene->scene) return Refusal{job.scene->mistakes, kBadFile};
    job.names.name = job.scene->scene->name;
  } else {
    job.instrument = load_graph_leniently(file, root_of(file));
    if (job.instrument->spec == nullptr) return Refusal{job.instrument->errors, kBadFile};
    job.names.name = job.instrument->spec->name;
  }
  return std::nullopt;
}

std::optional<Refusal> read(const CheckOptions& options, CheckJob& job) {
  if (auto refusal = load(options, job)) return refusal;
  Quantities quantity;
  auto& world = job.options.world;
  if (!options.rate.empty()) {
    const auto rate = parse_rate(options.rate);
    if (rate) world.rate = *rate;
    if (!rate && !quantity.wrong) quantity.wrong = rate.error();
  }
  const auto delay = quantity(options.delay, "s", "delay");
  job.options.hand = {quantity.above_zero(options.hand_damping, "N s/m", "hand-damping"),
                      quantity.above_zero(options.hand_mass, "kg", "hand-mass")};
  world.device = {quantity.above_zero(options.device_mass, "kg", "device-mass"),
                  quantity.above_zero(options.device_damping, "N s/m", "device-damping")};
  job.options.push = quantity.above_zero(options.push, "N", "push");
  const auto set = parse_settings(options.set);
  if (!set) return Refusal{{set.error()}, kUsage};
  world.set = *set;
  if (quantity.wrong) return Refusal{{*quantity.wrong}, kUsage};
  if (delay && !(*delay >= 0 && *delay <= 10))
    return Refusal{{{Errc::OutOfRange, "--delay", "must be from 0 s to 10 s", ""}}, kUsage};
  return choose_delay(options, delay, job);
}

/// Predicts whether it is stable where the run takes it, and measures it there.
Checked<ExtremeRun> predict_and_run(const CheckJob& job, ExtremePlan plan) {
  if (!plan.linear) plan.expected = is_stable_with(job.subject(), plan.world, job.options.push);
  return run_extreme(job.subject(), plan);
}

Checked<std::vector<ExtremePlan>> all_plans(const CheckJob& job, const StabilityVerdict& verdict) {
  const auto world = RestingWorld::make(job.subject(), job.options.world);
  if (!world) return tl::unexpected(world.error());
  auto plans = border_runs(job.options.world, verdict);
  for (auto& plan : extremes_of(job.options.world, world->instrument())) plans.push_back(std::move(plan));
  return plans;
}

/// On all processors; this thread tells how far they are.
Checked<std::vector<ExtremeRun>> run_all(const CheckJob& job, const StabilityVerdict& verdict) {
  const auto plans = all_plans(job, verdict);
  if (!plans) return tl::unexpected(plans.error());
  std::vector<std::optional<Checked<ExtremeRun>>> made(plans->size());
  std::atomic<std::size_t> next{0};
  Progress progress{"running"};
  const auto work = [&](bool tells) {
    for (std::size_t i = next++; i < made.size(); i = next++) {
      if (tells) progress(static_cast<double>(i) / static_cast<double>(made.size()), (*plans)[i].what);
      made[i] = predict_and_run(job, (*plans)[i]);
    }
  };
  std::vector<std::future<void>> others;
  for (unsigned t = 1; t < std::thread::hardware_concurrency(); ++t)
    others.push_back(std::async(std::launch::async, work, false));
  work(true);
  for (auto& other : others) other.get();
  std::vector<ExtremeRun> runs;
  for (auto& run : made) {
    if (!*run) return tl::unexpected(run->error());
    runs.push_back(std::move(**run));
  }
  exclude_player_energy(runs);
  return runs;
}

int run_check(const CheckOptions& options) {
  CheckJob job;
  if (const auto refusal = read(options, job)) return report(refusal->errors), refusal->exit;
  std::vector<ExtremeRun> runs;
  auto verdict = [&] {
    Progress progress{"analysing the loops"};
    return analyse_stability(job.subject(), job.options, [&](double share) { progress(share); });
  }();
  if (!verdict) return report(verdict.error());
  if (!options.quick) {
    auto made = run_all(job, *verdict);
    if (!made) return report(made.error());
    runs = std::move(*made);
  }
  if (options.json)
    fmt::print("{}\n", to_json(job.names, *verdict, runs).dump(2));
  else
    print(job.names, *verdict, runs, options.verbose);
  return holds(*verdict, runs) ? kDone : kNo;
}

void add_device_options(CLI::App& command, CheckOptions& options) {
  command.add_option("--hand-damping", options.hand_damping, "what a fingertip adds to the device")
      ->capture_default_str();
  command.add_option("--hand-mass", options.hand_mass, "what a fingertip adds to the device")
      ->capture_default_str();
  command.add_option("--push", options.push, "force in contacts that are looked at closed")
      ->capture_default_str();
  command
      .add_option("--device-mass", options.device_mass, "an instrument without a scene pushes such a device")
      ->capture_default_str();
  command.add_option("--device-damping", options.device_damping, "its damping")->capture_default_str();
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
  add_device_options(*command, *options);
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
