#include <fmt/format.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "apps/commands.h"
#include "apps/console.h"
#include "apps/live/live_options.h"
#include "apps/play_notes.h"
#include "apps/play_report.h"
#include "engine/analysis/pitch_track.h"
#include "engine/analysis/story.h"
#include "engine/scene/measure.h"

namespace tactus::app {
namespace {

using Json = nlohmann::ordered_json;

struct PlayOptions {
  std::string target;
  std::string out = "out";
  std::vector<std::string> show;
  SceneRun run;
  LiveOptions live;
  std::optional<int> block;
  bool json = false;
};

/// What a drummer asks of a roll, where the scene has a stick and strikes.
Json report_of(const PlayedScene& played, const PlayedScene* compared) {
  const auto& recording = played.recording;
  Json json{{"scene", played.scene.name},
            {"sample_rate_hz", recording.sample_rate.value},
            {"delay_ms", 1e3 * recording.delay_frames / recording.sample_rate.value},
            {"duration_s", recording.seconds()},
            {"run_s", recording.run_seconds},
            {"real_time_factor", recording.seconds() / recording.run_seconds}};
  const auto strikes = strikes_of(recording);
  const auto hits = triggers_of(recording, "instrument.hit");
  if (recording.find("plant.contact") != nullptr) {
    Expectation all;
    all.of = "instrument.hit";
    const auto ask = [&](const char* what, const PlayedScene& of) {
      all.measure = what;
      all.of = std::string{what} == "restitution" ? "plant.stick" : "instrument.hit";
      return measure(of.recording, all).value_or(0);
    };
    const auto rhythm = rhythm_of(hits, 0, recording.seconds());
    json["strikes"] = strikes.size();
    json["hits"] = hits.size();
    json["missed"] = ask("missed", played);
    json["doubled"] = ask("doubled", played);
    json["longest_detection_ms"] = 1e3 * ask("detection_time", played);
    json["roll_rate_hz"] = rhythm.rate_hz;
    json["fewest_in_a_second"] = rhythm.fewest_in_a_second;
    json["spread"] = rhythm.spread;
    json["long_short"] = rhythm.long_short;
    json["growing_intervals"] = rhythm.growing;
    json["last_hit_s"] = rhythm.last_s;
    json["restitution"] = ask("restitution", played);
    if (compared != nullptr) {
      const auto other =
          rhythm_of(triggers_of(compared->recording, "instrument.hit"), 0, recording.seconds());
      json["compared"] = {{"name", compared->scene.compare->name},
                          {"restitution", ask("restitution", *compared)},
                          {"hits", other.count},
                          {"last_hit_s", other.last_s}};
    }
  }
  report_notes(json, played, compared);
  json["faults"] = Json::array();
  for (const auto& fault : recording.faults)
    json["faults"].push_back({{"node", fault.path}, {"count", fault.count}});
  json["bad_input_samples"] = recording.bad_inputs;
  json["guard"] = guard_json(recording.guard, recording.sample_rate);
  json["ports"] = ports_json(recording.ports);
  return json;
}

void print_roll(const Json& json) {
  fmt::print(
      "  hits heard          {}, of {} strikes above 5 N {} missed; {} doubled; heard within {:.2f} ms\n",
      json["hits"].get<int>(), json["strikes"].get<int>(), json["missed"].get<double>(),
      json["doubled"].get<double>(), json["longest_detection_ms"].get<double>());
  fmt::print("  roll                {:.1f} hits a second, at least {} in any second, spread {:.0f} %\n",
             json["roll_rate_hz"].get<double>(), json["fewest_in_a_second"].get<int>(),
             100 * json["spread"].get<double>());
  fmt::print(
      "  intervals           long/short {:.2f}, longest run of growing ones {}, last hit at {:.2f} s\n",
      json["long_short"].get<double>(), json["growing_intervals"].get<int>(),
      json["last_hit_s"].get<double>());
  fmt::print("  restitution         {:.2f}", json["restitution"].get<double>());
  if (json.contains("compared")) {
    const auto& other = json["compared"];
    fmt::print("; {} {:.2f}, and {} hits, the last at {:.2f} s", other["name"].get<std::string>(),
               other["restitution"].get<double>(), other["hits"].get<int>(),
               other["last_hit_s"].get<double>());
  }
  fmt::print("\n");
}

void print(const Json& json, const PlayedScene& played) {
  const auto& scene = played.scene;
  fmt::print("{}\n{}\n\n", scene.name, scene.about);
  fmt::print(
      "  played              {:g} s at {:g} Hz with {:g} ms of delay, in {:.2f} s: {:.0f} times real time\n",
      json["duration_s"].get<double>(), json["sample_rate_hz"].get<double>(), json["delay_ms"].get<double>(),
      json["run_s"].get<double>(), json["real_time_factor"].get<double>());
  if (json.contains("strikes")) print_roll(json);
  print_notes(json);
  print_guard(played.recording.guard, played.recording.sample_rate);
  print_ports(played.recording.ports);
  fmt::print("  faults              {}\n",
             json["faults"].empty() && json["bad_input_samples"] == 0 ? "none" : "");
  for (const auto& fault : json["faults"])
    fmt::print("                      {} gave something that is not a number, {} times\n",
               fault["node"].get<std::string>(), fault["count"].get<std::int64_t>());
  if (json["bad_input_samples"] != 0)
    fmt::print("                      {} samples from the sensors were no numbers\n",
               json["bad_input_samples"].get<std::int64_t>());
}

std::string slug(const std::string& name) {
  std::string text;
  for (const char c : name)
    text += (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ? c : '_';
  return text.empty() ? "scene" : text;
}

/// What all files of a run begin with.
std::string base_of(const PlayOptions& options, const PlayedScene& played) {
  return (std::filesystem::path{options.out} / slug(played.scene.name)).string();
}

Result<std::pair<double, double>> shown_times(const PlayOptions& options, const SceneRecording& recording) {
  // A melody as a whole; of what is quick, the first second.
  const double shown = melody_of(recording) ? recording.seconds() : std::min(1.0, recording.seconds());
  if (options.show.empty()) return std::pair{0.0, shown};
  const auto from = parse_option(options.show[0], "s", "show");
  const auto to = parse_option(options.show[1], "s", "show");
  if (!from) return tl::unexpected(from.error());
  if (!to) return tl::unexpected(to.error());
  if (*from >= *to || *from >= recording.seconds())
    return fail(Errc::OutOfRange, "--show", "shows nothing of this scene",
                "give two rising times within its duration");
  return std::pair{*from, *to};
}

/// Sensors and drives as one sound file each; what moved as a third, its metres and newtons unscaled.
Result<std::vector<std::string>> write_files(const PlayOptions& options, const PlayedScene& played) {
  std::error_code ignored;
  std::filesystem::create_directories(options.out, ignored);
  const auto base = base_of(options, played);
  std::vector<std::string> written;
  const auto write = [&](const std::string& suffix,
                         const std::vector<const RecordedSignal*>& signals) -> Status {
    if (signals.empty()) return {};
    Samples samples;
    samples.sample_rate = played.recording.sample_rate;
    std::string names;
    for (const auto* signal : signals) {
      samples.channels.push_back(signal->samples);
      names += (names.empty() ? "" : ", ") + signal->name.substr(signal->name.find('.') + 1);
      if (!signal->dimension.plain()) names += " [" + to_string(signal->dimension) + "]";
    }
    const auto path = base + suffix;
    written.push_back(path + "  " + names);
    return write_wav(path, samples);
  };
  std::vector<const RecordedSignal*> sensors, drives, motion;
  for (const auto& name : played.recording.inputs)
    sensors.push_back(played.recording.find("instrument." + name));
  for (const auto& name : played.recording.outputs)
    drives.push_back(played.recording.find("instrument." + name));
  for (const auto& signal : played.recording.signals)
    if (!signal.name.starts_with("instrument.") && !signal.dimension.plain()) motion.push_back(&signal);
  if (auto status = write("_sensors.wav", sensors); !status) return tl::unexpected(status.error());
  if (auto status = write("_drives.wav", drives); !status) return tl::unexpected(status.error());
  if (auto status = write("_motion.wav", motion); !status) return tl::unexpected(status.error());
  const auto times = shown_times(options, played.recording);
  if (!times) return tl::unexpected(times.error());
  const auto picture = base + ".svg";
  if (auto status = write_svg(picture, story(played.scene, played.recording, times->first, times->second));
      !status)
    return tl::unexpected(status.error());
  written.push_back(picture + fmt::format("  the picture, {:g} s to {:g} s", times->first, times->second));
  return written;
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

int run(const PlayOptions& options) {
  if (options.live.live()) return play_on_card(options);
  if (const auto stray = options.live.stray(); !stray.empty())
    return report(Error{Errc::BadArgument, stray, "is for sound cards",
                        "give --device, --backend or --rig too"}),
           kUsage;
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
  auto json = report_of(*played, compared ? &*compared : nullptr);
  bool holds = json["faults"].empty();
  json["expected"] = Json::array();
  for (const auto& outcome : *outcomes) {
    holds = holds && outcome.holds;
    json["expected"].push_back({{"name", outcome.name},
                                {"value", outcome.value},
                                {"unit", outcome.unit},
                                {"wanted", outcome.wanted},
                                {"holds", outcome.holds}});
  }
  auto written = write_files(options, *played);
  if (!written) return report(written.error());
  const auto kept = base_of(options, *played) + ".json";
  if (auto status = write_json(kept, json); !status) return report(status.error());
  written->push_back(kept + "  this report, with what the guard did");
  if (options.json) {
    json["written"] = *written;
    fmt::print("{}\n", json.dump(2));
    return holds ? kDone : kNo;
  }
  print(json, *played);
  if (!outcomes->empty()) fmt::print("\n  expected of this scene\n");
  for (const auto& outcome : *outcomes)
    fmt::print("    {}  {:16} {:.4g}{}, {}\n", outcome.holds ? "ok  " : "FAIL", outcome.name, outcome.value,
               outcome.unit.empty() ? "" : " " + outcome.unit, outcome.wanted);
  fmt::print("\n  written\n");
  for (const auto& line : *written) fmt::print("    {}\n", line);
  return holds ? kDone : kNo;
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
  command->add_option("--out", options->out, "folder for the WAV files and the picture")
      ->capture_default_str();
  command
      ->add_option("--show", options->show,
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
  command->callback([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace tactus::app
