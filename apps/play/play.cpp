#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "apps/cli/commands.h"
#include "apps/cli/console.h"
#include "apps/cli/writable.h"
#include "apps/play/live/live_options.h"
#include "apps/play/play_files.h"
#include "apps/play/play_report.h"
#include "apps/play/report_sections.h"
#include "engine/scene/measures/measure.h"

namespace tactus::app {
namespace {

using Json = nlohmann::ordered_json;

struct PlayOptions {
  std::string target;
  PlayFiles files;
  SceneRun run;
  LiveOptions live;
  std::optional<int> block;
  bool json = false;
};

/// What is reported of a played scene, for machines and for people.
struct Report {
  const PlayedScene& played;
  std::vector<std::unique_ptr<ReportSection>> sections;
  std::vector<Outcome> outcomes;

  bool holds() const {
    return played.recording.faults.empty() &&
           std::all_of(outcomes.begin(), outcomes.end(),
                       [](const Outcome& outcome) { return outcome.holds; });
  }
  double delay_ms() const { return 1e3 * played.recording.delay_frames / played.recording.sample_rate.value; }
  double times_real_time() const { return played.recording.seconds() / played.recording.run_seconds; }
};

Json json_of(const Report& report) {
  const auto& recording = report.played.recording;
  Json json{{"scene", report.played.scene.name}, {"sample_rate_hz", recording.sample_rate.value},
            {"delay_ms", report.delay_ms()},     {"duration_s", recording.seconds()},
            {"run_s", recording.run_seconds},    {"real_time_factor", report.times_real_time()}};
  for (const auto& section : report.sections) section->add_to(json);
  json["faults"] = Json::array();
  for (const auto& fault : recording.faults)
    json["faults"].push_back({{"node", fault.path}, {"count", fault.count}});
  json["bad_input_samples"] = recording.bad_inputs;
  json["guard"] = guard_json(recording.guard, recording.sample_rate);
  json["ports"] = ports_json(recording.ports);
  json["expected"] = Json::array();
  for (const auto& outcome : report.outcomes)
    json["expected"].push_back({{"name", outcome.name},
                                {"value", outcome.value},
                                {"unit", outcome.unit},
                                {"wanted", outcome.wanted},
                                {"holds", outcome.holds}});
  return json;
}

void print(const Report& report) {
  const auto& [scene, recording] = report.played;
  fmt::print("{}\n{}\n\n", scene.name, scene.about);
  fmt::print(
      "  played              {:g} s at {:g} Hz with {:g} ms of delay, in {:.2f} s: {:.0f} times real time\n",
      recording.seconds(), recording.sample_rate.value, report.delay_ms(), recording.run_seconds,
      report.times_real_time());
  for (const auto& section : report.sections) fmt::print("{}", section->text());
  print_guard(recording.guard, recording.sample_rate);
  print_ports(recording.ports);
  fmt::print("  faults              {}\n",
             recording.faults.empty() && recording.bad_inputs == 0 ? "none" : "");
  for (const auto& fault : recording.faults)
    fmt::print("                      {} gave non-finite values {} times\n", fault.path, fault.count);
  if (recording.bad_inputs != 0)
    fmt::print("                      {} non-finite sensor samples replaced by zero\n", recording.bad_inputs);
  if (!report.outcomes.empty()) fmt::print("\n  expected of this scene\n");
  for (const auto& outcome : report.outcomes)
    fmt::print("    {}  {:16} {:.4g}{}, {}\n", outcome.holds ? "ok  " : "FAIL", outcome.name, outcome.value,
               outcome.unit.empty() ? "" : " " + outcome.unit, outcome.wanted);
}

/// On a sound card the options that both ways have mean the same.
int play_on_card(const PlayOptions& options) {
  auto live = options.live;
  live.target = options.target;
  live.rate = options.run.rate;
  live.duration = options.run.duration;
  live.delay = options.run.delay;
  live.block = options.block;
  live.set = options.run.set;
  live.guard = options.run.guard;
  live.json = options.json;
  return play_live(live);
}

int run_play(const PlayOptions& options) {
  if (options.live.live()) return play_on_card(options);
  if (const auto stray = options.live.stray(); !stray.empty())
    return report(
        Error{Errc::BadArgument, stray, "is for sound cards", "give --device, --backend or --rig too"});
  auto scene_run = options.run;
  scene_run.block = options.block.value_or(scene_run.block);
  scene_run.file = resolve_target(options.target, "scene.toml");
  const auto played = play_file(scene_run);
  if (!played) return report(played.error());
  const auto outcomes = check_expectations(played->scene, played->recording);
  if (!outcomes) return report(outcomes.error());
  std::optional<PlayedScene> compared;
  if (played->scene.compare) {
    scene_run.overrides = played->scene.compare->set;
    scene_run.said = true;
    auto other = play_file(scene_run);
    if (!other) return report(other.error());
    compared = std::move(*other);
  }
  const Report finished{*played, sections_of(*played, compared ? &*compared : nullptr), *outcomes};
  auto json = json_of(finished);
  auto written = write_files(options.files, *played);
  if (!written) return report(written.error());
  const auto kept = base_of(options.files, *played) + ".json";
  if (auto status = write_json(kept, json); !status) return report(status.error());
  written->push_back(kept + "  this report, with what the guard did");
  if (options.json) {
    json["written"] = *written;
    fmt::print("{}\n", json.dump(2));
  } else {
    print(finished);
    fmt::print("\n  written\n");
    for (const auto& line : *written) fmt::print("    {}\n", line);
  }
  return finished.holds() ? kDone : kNo;
}

}  // namespace

void add_play(CLI::App& app, int& exit_code) {
  auto* command =
      app.add_subcommand("play", "Play an instrument on a sound card, or a scene in the simulated world");
  auto options = std::make_shared<PlayOptions>();
  command
      ->add_option(
          "FILE", options->target,
          "instrument or scene; a folder means its instrument.toml on a card, otherwise its scene.toml")
      ->required();
  command->add_option("--delay", options->run.delay,
                      "system delay instead of the scene's, such as \"10 ms\"");
  command->add_option("--rate", options->run.rate, "sample rate instead of the scene's");
  command->add_option("--duration", options->run.duration, "duration instead of the scene's");
  command->add_option("--block", options->block, "frames a block (the result does not depend on it); [64]")
      ->check(CLI::Range(1, 8192));
  command->add_option("--set", options->run.set,
                      "NAME=VALUE: a control of the instrument, or plant.NAME=VALUE");
  add_guard_options(*command, options->run.guard);
  command->add_option("--out", options->files.folder, "folder for the WAV files and the picture")
      ->check(writable_folder())
      ->capture_default_str();
  command
      ->add_option("--show", options->files.show,
                   "FROM TO: times that the picture shows, such as --show \"2 s\" \"3 s\"")
      ->expected(2);
  command->add_flag("--json", options->json, "for machines");
  add_live_options(*command, options->live);
  command->footer(
      "Examples:\n  tactus play instruments/haptic_drum\n  tactus play instruments/haptic_drum --device "
      "jack:system\n  tactus play instruments/haptic_drum --delay \"40 "
      "ms\" --set strength=0.5\n"
      "  tactus play instruments/haptic_drum/galloping.toml --show \"2 s\" \"3 s\"\n"
      "Exit code 1: it ran, and did not do what the scene expects.");
  command->callback([options, &exit_code] { exit_code = run_play(*options); });
}

}  // namespace tactus::app
