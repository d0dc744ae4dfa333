#include "apps/render/render.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "apps/cli/console.h"
#include "apps/render/render_events.h"
#include "apps/study/study.h"
#include "engine/nodes/table.h"

namespace tactus::app {
namespace {

/// A recording must not be lost to its own rendering.
void check_overwriting(const RenderOptions& options) {
  const auto& input = options.replay.empty() ? options.in : options.replay;
  std::error_code none;
  for (const auto& [option, written] :
       {std::pair{"--out ", &options.out}, {"--sound ", &options.sound}, {"--events ", &options.events}})
    if (!written->empty() && !input.empty() && std::filesystem::equivalent(*written, input, none))
      exit_with(
          {Errc::BadArgument, option + *written, "would overwrite the input file", "choose another name"});
}

EventCollector events_of(const SceneRecording& recording) {
  const std::string prefix = "instrument.";
  std::vector<std::string> names;
  std::vector<const double*> taps;
  for (const auto& signal : recording.signals) {
    if (!signal.name.starts_with(prefix) || signal.name.find('.', prefix.size()) == std::string::npos)
      continue;
    names.push_back(signal.name.substr(prefix.size()));
    taps.push_back(signal.samples.data());
  }
  EventCollector events{names, recording.sample_rate};
  const auto frames = recording.signals.empty() ? 0 : std::ssize(recording.signals.front().samples);
  if (frames > 0) events.add(taps, static_cast<int>(frames));
  return events;
}

void write_signals(RenderFiles& files, const SceneRecording& recording) {
  constexpr std::int64_t kBlock = 1 << 14;
  std::vector<const double*> at;
  for (const auto& name : recording.outputs)
    at.push_back(recording.find("instrument." + name)->samples.data());
  const auto frames = recording.signals.empty() ? 0 : std::ssize(recording.signals.front().samples);
  for (std::int64_t done = 0; done < frames; done += kBlock) {
    const auto count = std::min(kBlock, frames - done);
    or_exit(files.write(at.data(), static_cast<int>(count)));
    for (auto& channel : at) channel += count;
  }
}

int render_scene(const RenderOptions& options, const Target& target) {
  const auto [scene, recording, networks, inputs] = play_file(target, options);
  const auto rate = recording.sample_rate;
  RenderFiles files{options, recording.outputs, recording.sounds, rate};
  write_signals(files, recording);
  const auto events = events_of(recording).json();
  files.close(events);
  const int exit_code = recording.guard.faded() ? kNo : kDone;
  if (options.json) {
    print_json({{"scene", scene.name},
                {"events", count_of(events)},
                {"run_seconds", recording.run_seconds},
                {"faults", faults_json(recording.faults)},
                {"guard", guard_json(recording.guard, rate)},
                {"ports", ports_json(recording.ports)},
                {"network_solvers", networks_json(networks)}});
    return exit_code;
  }
  fmt::print("{}: {:.3f} s, {} events, {:.0f} times real time\n", scene.name, recording.seconds(),
             count_of(events), recording.seconds() / recording.run_seconds);
  print_guard(recording.guard, rate);
  print_ports(recording.ports);
  print_networks(networks);
  print_faults(recording);
  return exit_code;
}

/// The measured errors beside the bound.
Table error_table(const WorkPrecision& result) {
  const auto& point = result.points.front();
  const auto bound = point.error_bound();
  Table table{{{"compared", "error", "bound", "own error of the reference", "reference"}}};
  for (std::size_t a = 0; a < point.errors.size(); ++a) {
    const auto& used = result.references[a];
    table.rows.push_back({fmt::format("{}: {} of {}", used.accuracy, used.measure, used.of),
                          fmt::format("{:.2e}{}", point.errors[a], point.trusted(a) ? "" : "?"),
                          bound ? fmt::format("{:.2e}", *bound) : "none",
                          used.own_error >= 1  ? "it failed"
                          : used.own_error > 0 ? fmt::format("{:.1e}", used.own_error)
                                               : "",
                          used.what});
  }
  return table;
}

std::string error_text(const WorkPrecision& result) {
  const auto& point = result.points.front();
  auto text = fmt::format("{}\n\n", result.scene);
  if (!point.known()) return text + (point.refused ? to_string(*point.refused) : "  unstable") + "\n";
  text += fmt::format("  {:.1f} ns per frame, {:.2g} % of real time at {:g} kHz\n", point.ns_per_frame,
                      100 * point.load(), point.variant.rate.value / 1e3);
  for (const auto& network : point.networks) text += "  " + describe(network) + "\n";
  text += "\n" + error_table(result).text() +
          "\nErrors are relative. The bound is that of each resonance, decay and contact, and of the force "
          "of what slips; the error of a path adds them up over its duration.\n";
  bool trusted = true;
  for (std::size_t a = 0; a < point.errors.size(); ++a) trusted = trusted && point.trusted(a);
  return text + (trusted ? "" : "?: less than ten times the reference's own error, so in doubt.\n");
}

/// Errors of one run and its time a frame.
int report_accuracy(const RenderOptions& options, const Target& target) {
  auto scene = or_exit(load_scene(target));
  if (!options.rate.empty()) scene.rate = parse_rate(options.rate);
  if (!options.delay.empty()) scene.delay = parse_delay(options.delay);
  if (!options.duration.empty()) scene.duration = parse_duration(options.duration, 3600_s);
  const auto result = or_exit(evaluate_as_written(scene, standard_nodes()));
  options.json ? print_json(json_of(result)) : fmt::print("{}", error_text(result));
  return result.points.front().known() ? kDone : kNo;
}

int run_render(const RenderOptions& options) {
  check_overwriting(options);
  if (!options.replay.empty()) return render_take(options);
  if (options.target.empty())
    exit_with({Errc::Missing, "", "there is nothing to render", "name an instrument, a scene or a take"});
  const auto target =
      resolve_target(options.target, options.in.empty() ? FolderMeans::Scene : FolderMeans::Instrument);
  if (options.error) return report_accuracy(options, target);
  if (options.out.empty() && options.sound.empty() && options.events.empty() && !options.json)
    print_note("note: nothing is written; --out FILE writes the outputs");
  if (!target.scene) return render_instrument(options, target);
  if (!options.in.empty())
    exit_with({Errc::BadArgument, "--in", options.target + " is a scene, whose plant provides the inputs",
               "omit --in, or name the instrument"});
  return render_scene(options, target);
}

}  // namespace

void add_render(CLI::App& app, int& exit_code) {
  auto [command, options] =
      add_command(app, "render", "Run an instrument on a WAV file, or run a scene, without hardware",
                  exit_code, run_render);
  command.add_option(
      "FILE", options.target,
      "instrument or scene file; for a folder, its scene.toml, or with --in its instrument.toml");
  command.add_option("--replay", options.replay,
                     "a recording made with --record: replay it and check that the drives match bit for bit; "
                     "with FILE, feed the recorded sensor signals to that instrument");
  command.add_option("--in", options.in,
                     "what the inputs of an instrument receive: a WAV file (channel k feeds the k-th input); "
                     "its rate and duration are the defaults; it is resampled if --rate differs");
  command
      .add_option("--out", options.out,
                  "file to write: a WAV file of all outputs, in the order of the instrument file")
      ->check(writable_file());
  command.add_option("--sound", options.sound, "WAV file for the monitor output, without the drives")
      ->check(writable_file());
  command
      .add_option(
          "--events", options.events,
          "JSON file for detected events: {\"events\": [{\"time_s\": …, \"node\": …, \"level_db\": …}]}")
      ->check(writable_file());
  command.add_option("--format", options.format, "sample format of the WAV files")
      ->check(CLI::IsMember({"float", "24"}))
      ->capture_default_str();
  add_player_options(command, options);
  command
      .add_flag("--error", options.error,
                "report the numerical error of a scene's networks beside its bound, and the computing time "
                "per frame")
      ->excludes("--in", "--out", "--sound", "--events", "--replay", "--set");
  for (const auto* option : {"--in", "--sound", "--events", "--rate", "--duration"})
    command.get_option("--replay")->excludes(option);
  command.footer(
      "Examples:\n  tactus render instruments/haptic_drum --in hits.wav --out drive.wav --events "
      "events.json\n"
      "  tactus render --replay take.wav --out drives.wav\n"
      "  tactus render instruments/cellomobo --sound phrase.wav\n"
      "  tactus render instruments/haptic_drum --delay \"10 ms\" --out drive.wav\n"
      "  tactus render instruments/numerics/woofer --error");
}

}  // namespace tactus::app
