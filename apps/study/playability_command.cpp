#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <optional>

#include "apps/cli/commands.h"
#include "apps/cli/console.h"
#include "apps/cli/interrupts.h"
#include "apps/cli/writable.h"
#include "apps/study/playability_report.h"
#include "apps/study/study_commands.h"
#include "apps/study/sweep_range.h"
#include "engine/graph/file/quantity.h"
#include "engine/nodes/table.h"
#include "engine/study/playability/playability_plot.h"

namespace tactus::app {
namespace {

struct PlayabilityArguments {
  std::string target, delay = "0:40:1 ms", gain, within = "20 %", duration, part, keep, picture;
  std::vector<std::string> over, set;
  int draws = 0, workers = 0;
  std::uint64_t seed = 1;
  bool json = false;
};

Result<std::vector<double>> delays_of(const std::string& text) {
  const auto values = parse_steps(text, "--delay");
  if (!values) return tl::unexpected(values.error());
  std::vector<double> delays;
  for (const auto& value : *values) {
    if (!value.dimension || !(*value.dimension == Dimension{.second = 1}))
      return fail(Errc::UnitMismatch, "--delay", "'" + text + "' is no range of times",
                  "write for instance \"0:40:1 ms\"");
    if (value.si < 0 || value.si > 1)
      return fail(Errc::OutOfRange, "--delay", "a delay of " + fmt::format("{:g} s", value.si),
                  "choose 0 s to 1 s");
    delays.push_back(value.si);
  }
  return delays;
}

Result<SweptValue> swept_of(const std::string& text, const SceneSpec& scene) {
  const auto equals = text.find('=');
  if (equals == std::string::npos || equals == 0)
    return fail(Errc::Syntax, "--over", "'" + text + "' is not NAME=FROM:TO:COUNT",
                "write for instance strength=0.2:1:5");
  auto values = parse_spread(text.substr(equals + 1), "--over");
  if (!values) return tl::unexpected(values.error());
  const auto name = text.substr(0, equals);
  const auto what = scene.gesture(name) == nullptr          ? SweptValue::What::Control
                    : values->front().dimension.has_value() ? SweptValue::What::Held
                                                            : SweptValue::What::Scaled;
  return SweptValue{name, std::move(*values), what};
}

/// "2/4": the second of four shares.
Status read_part(const std::string& text, PlayabilityOptions& study) {
  if (text.empty()) return {};
  int part = 0, parts = 0, read = 0;
  const bool whole = std::sscanf(text.c_str(), "%d/%d%n", &part, &parts, &read) == 2 &&
                     read == static_cast<int>(text.size());
  if (!whole || part < 1 || part > parts || parts > 10000)
    return fail(Errc::Syntax, "--part", "'" + text + "' is no part of a whole", "write for instance 2/4");
  if (study.keep.empty())
    return fail(Errc::Missing, "--part", "a part of the runs is of use only where it is kept",
                "add --keep FOLDER");
  study.part = part - 1;
  study.parts = parts;
  return {};
}

/// "6 dB": both ways. A bare number might be meant as decibels or as a factor.
Status read_gain(const std::string& text, PlayabilityOptions& study) {
  if (text.empty()) return {};
  const auto gain = parse_option(text, "", "gain");
  if (!gain) return tl::unexpected(gain.error());
  if (read_quantity(Value{text, {}})->bare)
    return fail(Errc::UnitMismatch, "--gain", "'" + text + "' may be decibels or a factor",
                fmt::format("write \"{0} dB\", or \"{1:g} %\" for {0} times as strong", text, 100 * *gain));
  if (!(*gain > 0 && *gain <= 100))
    return fail(Errc::OutOfRange, "--gain", "must lie above 0 and at most at 40 dB", "");
  study.gains = {1 / *gain, *gain};
  return {};
}

/// What is swept has no other value.
Status check_swept(const PlayabilityOptions& study) {
  for (auto swept = study.over.begin(); swept != study.over.end(); ++swept) {
    const auto same = [&](const SweptValue& other) { return other.name == swept->name; };
    if (std::any_of(study.over.begin(), swept, same))
      return fail(Errc::BadArgument, "--over", "'" + swept->name + "' is swept twice", "sweep it once");
    if (study.set.contains(swept->name))
      return fail(Errc::BadArgument, "--set",
                  "'" + swept->name + "' is swept by --over, and cannot be set too", "leave one of them out");
  }
  return {};
}

Status read_variants(const PlayabilityArguments& options, PlayabilityOptions& study) {
  study.draws = options.draws;
  study.seed = options.seed;
  const auto within = parse_option(options.within, "", "within");
  if (!within) return tl::unexpected(within.error());
  if (!(*within > 0 && *within < 1))
    return fail(Errc::OutOfRange, "--within", "must lie above 0 and below 100 %", "");
  study.within = *within;
  return read_gain(options.gain, study);
}

Result<PlayabilityOptions> study_options(const PlayabilityArguments& options, SceneSpec& scene) {
  PlayabilityOptions study;
  study.workers = options.workers;
  study.keep = options.keep;
  auto delays = delays_of(options.delay);
  if (!delays) return tl::unexpected(delays.error());
  study.delays_s = std::move(*delays);
  for (const auto& text : options.over) {
    auto swept = swept_of(text, scene);
    if (!swept) return tl::unexpected(swept.error());
    study.over.push_back(std::move(*swept));
  }
  auto set = parse_settings(options.set);
  if (!set) return tl::unexpected(set.error());
  study.set = std::move(*set);
  if (auto status = check_swept(study); !status) return tl::unexpected(status.error());
  if (!options.duration.empty()) {
    const auto duration = parse_option(options.duration, "s", "duration");
    if (!duration) return tl::unexpected(duration.error());
    const double least = scene.playability ? scene.playability->from_s + 1 : 1;
    if (!(*duration >= least && *duration <= 3600))
      return fail(Errc::OutOfRange, "--duration", "leaves less than a second to be judged, or is too long",
                  fmt::format("choose {:g} s to an hour", least));
    scene.duration = Seconds{*duration};
  }
  if (auto status = read_part(options.part, study); !status) return tl::unexpected(status.error());
  if (auto status = read_variants(options, study); !status) return tl::unexpected(status.error());
  return study;
}

int told_part(const PlayabilityStudy& study, const PlayabilityOptions& options) {
  fmt::print(stderr, "part {} of {} is done; {} of {} runs are known in {}\n", options.part + 1,
             options.parts, study.finished(), study.runs.size(), options.keep.string());
  return kDone;
}

int told_interrupted(const PlayabilityStudy& study, const PlayabilityOptions& options) {
  fmt::print(stderr, "interrupted after {} of {} runs; {}\n", study.finished(), study.runs.size(),
             options.keep.empty() ? "nothing was kept: --keep FOLDER goes on where it was ended"
                                  : "the same command goes on from here");
  return kInterrupted;
}

int publish(const PlayabilityStudy& study, const PlayabilityArguments& options) {
  Status written;
  if (!options.picture.empty()) written = write_picture(options.picture, study);
  if (options.json)
    fmt::print("{}\n", json_of(study).dump(2));
  else
    fmt::print("{}", text_of(study));
  if (!written) return report(written.error());
  const auto verdicts = study.verdicts();
  return std::all_of(verdicts.begin(), verdicts.end(), [](const auto& v) { return v.playable; }) ? kDone
                                                                                                 : kNo;
}

int run_playability(const PlayabilityArguments& options) {
  const auto file = resolve_target(options.target, "scene.toml");
  auto scene = load_scene(file, root_of(file));
  if (!scene) return report(scene.error());
  auto studied = study_options(options, *scene);
  if (!studied) return report(studied.error()), kUsage;
  install_signal_handlers();
  std::optional<Progress> progress{"playing " + scene->name};
  studied->progress = [&](double share) { (*progress)(share); };
  studied->stop = interrupted;
  const auto study = study_playability(*scene, standard_nodes(), *studied);
  progress.reset();
  if (!study) return report(study.error());
  if (interrupted() && !study->complete()) return told_interrupted(*study, *studied);
  if (studied->parts > 1) return told_part(*study, *studied);
  return publish(*study, options);
}

}  // namespace

void add_study_playability(CLI::App& study, int& exit_code) {
  auto* command = study.add_subcommand("playability", "How playable a scene is, over the delay");
  auto options = std::make_shared<PlayabilityArguments>();
  command->add_option("SCENE", options->target, "scene with [playability]; a folder means its scene.toml")
      ->required();
  command->add_option("--delay", options->delay, "FROM:TO:STEP, or one")->capture_default_str();
  command
      ->add_option(
          "--over", options->over,
          "NAME=FROM:TO:COUNT, or COUNT:log for equal factors: sweeps a control (strength, plant.grip), or a "
          "gesture: scales it, or with a unit holds it there; at most two")
      ->expected(1, 2)
      ->take_all();
  command->add_option("--set", options->set, "NAME=VALUE: a control of the instrument, or plant.NAME=VALUE");
  command->add_option("--duration", options->duration, "of each run, instead of the scene's");
  command->add_option("--gain", options->gain,
                      "tries the actuator that much weaker and stronger too, as in \"6 dB\"");
  command->add_option("--draws", options->draws, "tries so many other plants too")
      ->check(CLI::Range(0, 100000))
      ->capture_default_str();
  command->add_option("--within", options->within, "how far all their quantities are from the plant's")
      ->capture_default_str();
  command->add_option("--seed", options->seed, "of the draws")->capture_default_str();
  command
      ->add_option("--keep", options->keep,
                   "folder of finished runs: what is there is not played again, whatever ended it")
      ->check(writable_folder());
  command->add_option("--part", options->part, "I/N: plays that share of the runs into --keep, and no more");
  command->add_option("--workers", options->workers, "threads; [one a core]")->check(CLI::Range(1, 1024));
  command->add_option("--svg", options->picture, "the picture: curves, or maps where something is swept")
      ->check(writable_file());
  command->add_flag("--json", options->json, "for machines");
  command->footer(
      "Examples:\n  tactus study playability instruments/haptic_drum\n"
      "  tactus study playability instruments/haptic_drum --over strength=0.2:1:5 --svg drum.svg\n"
      "  tactus study playability instruments/haptic_drum --delay \"20 ms\" --gain \"6 dB\" --draws 50\n"
      "  tactus study playability instruments/cellomobo/open_string.toml --delay \"0:40:5 ms\" --over "
      "\"tuned=55:880:5:log Hz\"\n"
      "What is judged stands under [playability] in the scene; docs/playability.md says how.\n"
      "Exit code 1: there is a delay at which it is not playable. 5: interrupted.");
  command->callback([options, &exit_code] { exit_code = run_playability(*options); });
}

}  // namespace tactus::app
