#include "apps/play/play_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <iterator>
#include <utility>

#include "apps/cli/console.h"
#include "apps/cli/rig_files.h"
#include "apps/cli/warnings.h"
#include "apps/play/world.h"
#include "engine/core/decibels.h"
#include "engine/core/index.h"
#include "engine/nodes/networks/solver_names.h"
#include "engine/nodes/table.h"
#include "engine/scene/measures/events.h"
#include "engine/scene/measures/notes/pitch_track.h"

namespace tactus::app {
namespace {

using Signals = std::vector<const RecordedSignal*>;

std::string slug(const std::string& name) {
  std::string text;
  for (const unsigned char c : name) text += std::isalnum(c) != 0 ? static_cast<char>(c) : '_';
  return text.empty() ? "scene" : text;
}

Signals of_instrument(const SceneRecording& recording, const std::vector<std::string>& names) {
  Signals signals;
  for (const auto& name : names) signals.push_back(recording.find("instrument." + name));
  return signals;
}

Signals motion_in(const SceneSpec& scene, const SceneRecording& recording) {
  Signals signals;
  if (scene.bench) return signals;  // they are the sensors
  for (const auto& signal : recording.signals)
    if (!signal.name.starts_with("instrument.") && !signal.dimension.plain()) signals.push_back(&signal);
  return signals;
}

std::string named(const Signals& signals) {
  std::vector<std::string> names;
  for (const auto* signal : signals)
    names.push_back(signal->name.substr(signal->name.find('.') + 1) +
                    (signal->dimension.plain() ? "" : " [" + to_string(signal->dimension) + "]"));
  return fmt::format("{}", fmt::join(names, ", "));
}

Samples samples_of(const Signals& signals, Hertz rate) {
  Samples samples;
  samples.sample_rate = rate;
  for (const auto* signal : signals) samples.channels.push_back(signal->samples);
  return samples;
}

void write_signals(const std::string& path, const Signals& signals, Hertz rate,
                   std::vector<std::string>& written) {
  if (signals.empty()) return;
  or_exit(write_wav(path, samples_of(signals, rate)));
  written.push_back(path + "  " + named(signals));
}

/// The monitor output with its gain, as integers, which every program opens.
void write_sound(const std::string& path, const Signals& signals, const PlayedScene& played,
                 std::vector<std::string>& written) {
  if (signals.empty()) return;
  const double gain = played.scene.monitor_gain;
  auto samples = samples_of(signals, played.recording.sample_rate);
  double peak = 0;
  for (auto& channel : samples.channels)
    for (auto& sample : channel) peak = std::max(peak, std::abs(sample *= gain));
  or_exit(write_wav(path, samples, WavEncoding::Pcm24));
  written.push_back(
      fmt::format("{}  {}, {}{}{}", path, named(signals),
                  peak > 0 ? fmt::format("peak {:.0f} dBFS", amplitude_to_db(peak)) : "silent",
                  gain != 1 ? fmt::format(", with a monitor gain of {:.0f} dB", amplitude_to_db(gain)) : "",
                  peak > 1 ? ", clipped: lower 'monitor' in the scene" : ""));
}

LimitSource profile_of(const GuardOptions& options) {
  if (options.profile.empty() || options.volts.empty())
    exit_with({Errc::BadArgument, options.profile.empty() ? "--volts-per-full-scale" : "--profile",
               "the profile and the voltage at full scale must be given together",
               "give both, as in --profile woofer --volts-per-full-scale 8"});
  const double volts = parse_option(options.volts, "V", "volts-per-full-scale", 1e-3, 1000);
  const auto file = or_exit(find_profile(options.profile, option_profile_folders(), "--profile"));
  const auto limits = limits_for(or_exit(load_profile(file)), volts);
  if (const auto status = check(limits); !status)
    exit_with({Errc::BadArgument, "--profile", status.error().what, status.error().remedy});
  return {LimitSource::Kind::Profile, "--profile " + options.profile + " (" + file.string() + ")", limits};
}

/// "woofer.ceiling=0.8" or "ceiling=0.8"
LimitRaise parse_raise(const std::string& text) {
  auto [name, value] = parse_assignment(text, "--raise-limit", "NAME=VALUE", "--raise-limit ceiling=0.8");
  const auto dot = name.rfind('.');
  if (dot == std::string::npos) return {{}, name, value};
  // Without a name the raise would be for every drive.
  if (dot == 0)
    exit_with(
        {Errc::Syntax, "--raise-limit", "'" + text + "' has no output before the dot",
         "name the output, as in OUTPUT" + text + ", or omit the dot to raise the limit of all drives"});
  return {name.substr(0, dot), name.substr(dot + 1), value};
}

Json limit_json(const LimitOrigin& limit) {
  Json json{{"limit", limit.limit}, {"value", limit.value}, {"source", limit.source}};
  if (limit.raised_from) json["raised_from"] = *limit.raised_from;
  return json;
}

}  // namespace

LimitBook apply(const GuardOptions& options, LimitBook limits) {
  if (!options.profile.empty() || !options.volts.empty()) limits.drives.push_back(profile_of(options));
  for (const auto& text : options.raise) limits.raises.push_back(parse_raise(text));
  return limits;
}

void announce_raises(const LimitBook& limits, const Plan& plan) {
  const auto outputs = limited_outputs(plan);
  or_exit(limits.check_raises(outputs));
  for (const auto& output : outputs)
    for (const auto& line : describe_raises(output.name, limits.of(output).origins))
      fmt::print(stderr, "warning: {}; keep hands away until its effect is known\n", line);
}

Json guard_json(const GuardReport& report, Hertz sample_rate) {
  const auto output_json = [&](const GuardedOutput& output) {
    Json stages = Json::object();
    for (std::size_t s = 0; s < kGuardStages; ++s) {
      const auto& count = output.counts[s];
      if (count.frames == 0) continue;
      stages[name_of(GuardStage::Index{s})] = {
          {"frames", count.frames},
          {"seconds", static_cast<double>(count.frames) / sample_rate.value},
          {"most_full_scale", count.most}};
    }
    Json json{{"output", output.name},
              {"limited", stages},
              {"coil_heat", output.heat.coil},
              {"body_heat", output.heat.body},
              {"coil_rise_kelvin", output.rise_kelvin}};
    for (const auto& limit : output.limits)
      if (limit.raised_from) json["raised"].push_back(limit_json(limit));
    return json;
  };
  const auto event_json = [](const GuardEvent& event) {
    return Json{{"frame", event.frame}, {"kind", name_of(event.kind)}, {"channel", event.channel}};
  };
  return {{"idle", report.idle()},
          {"outputs", list_of(report.outputs, output_json)},
          {"events", list_of(report.events, event_json)},
          {"in_words", describe(report, sample_rate)}};
}

Json limits_json(const GuardReport& report) {
  return list_of(report.outputs, [](const GuardedOutput& output) {
    return Json{{"output", output.name}, {"limits", list_of(output.limits, limit_json)}};
  });
}

void print_guard(const GuardReport& report, Hertz sample_rate) {
  auto lines = describe(report, sample_rate);
  if (lines.empty()) lines.push_back("no intervention");
  for (const auto& output : report.outputs)
    std::ranges::copy(describe_raises(output.name, output.limits), std::back_inserter(lines));
  const char* heading = "drive guard";
  for (const auto& line : lines) fmt::print("  {:<18}  {}\n", std::exchange(heading, ""), line);
}

void print_faults(const SceneRecording& recording) {
  const bool none = recording.faults.empty() && recording.bad_inputs == 0;
  fmt::print("  faults              {}\n", none ? "none" : "");
  for (const auto& fault : recording.faults)
    fmt::print("                      {} produced non-finite values {} times\n", fault.path, fault.count);
  if (recording.bad_inputs != 0)
    fmt::print("                      {} non-finite sensor samples replaced by zero\n", recording.bad_inputs);
}

void add_player_options(CLI::App& command, PlayerOptions& options) {
  command.add_option("--delay", options.delay, "system delay; such as \"10 ms\"; default: the scene's");
  command.add_option("--rate", options.rate, "sample rate; such as \"96 kHz\"; default: the scene's");
  command.add_option("--duration", options.duration, "duration; such as \"10 s\"; default: the scene's");
  command.add_option("--set", options.set,
                     "NAME=VALUE: sets a control, such as strength=0.5 or \"sensitivity=-40 dB\"; in a scene "
                     "also plant.NAME=VALUE");
  add_number(command, "--block", options.block,
             "block size in frames; the computed signals do not depend on it", 1, 8192);
  command.add_option("--profile", options.guard.profile,
                     "actuator profile for all drives (outputs to actuators): woofer, bass_shaker, "
                     "tactor_lra, voice_coil, … or a file; lower limits of the scene hold as well");
  command.add_option("--volts-per-full-scale", options.guard.volts,
                     "voltage at the actuator for a sample value of 1, such as 8 or \"8 V\"");
  command.add_option(
      "--raise-limit", options.guard.raise,
      "LIMIT=VALUE: raises a limit of all drives above every other source, such as ceiling=0.8; "
      "OUTPUT.LIMIT=VALUE: of one output; LIMIT: ceiling, slew, power, travel (excursion), direct_level (DC "
      "level) or direct_time (time above it)");
  command.add_flag("--json", options.json, "print the report as JSON");
}

PlayedScene play_file(const Target& target, const PlayerOptions& options,
                      const std::map<std::string, double>* compared) {
  const bool first = compared == nullptr;
  auto [loaded, inputs] = load_world(target, options.in, /*by_hand=*/false);
  if (!loaded.scene) throw CommandError{std::move(loaded.errors)};
  auto& scene = *loaded.scene;
  if (!options.duration.empty()) scene.duration = parse_duration(options.duration, 3600_s);
  SceneOptions changes;
  changes.set = parse_settings(options.set);
  if (!first)
    for (const auto& [name, value] : *compared) changes.set[name] = value;
  if (!options.delay.empty()) changes.delay = parse_delay(options.delay);
  if (!options.rate.empty()) changes.rate = parse_rate(options.rate);
  scene.drives = apply(options.guard, std::move(scene.drives));
  auto built = or_exit(build_scene(loaded, standard_nodes(), changes));
  if (first) {
    announce_raises(scene.drives, built.instrument->plan());
    print_warnings(built.instrument->plan());
    print_warnings(built.plant->plan());
  }
  const auto* instrument = scene.part("instrument");
  if (first && changes.delay && instrument != nullptr && instrument->graph != nullptr)
    announce_delay(*instrument->graph, changes.delay->value);
  Progress progress{"playing " + scene.name};
  SceneTimes times{built, frames_in(scene.duration, built.plant->plan().sample_rate)};
  auto recording = or_exit(play_scene(
      scene, built, options.block.value_or(64), [&](double share) { progress(share); }, &times));
  return {std::move(scene), std::move(recording), times.networks(), std::move(inputs)};
}

Json faults_json(const std::vector<FaultCount>& faults) {
  return list_of(faults, [](const FaultCount& fault) -> Json {
    return {{"node", fault.path}, {"count", fault.count}};
  });
}

Json gaps_json(const Health& health) {
  Json json = Json::object();
  for (std::size_t g = 0; g < kGaps; ++g) json[name_of(static_cast<Gap>(g))] = health.gaps[g];
  return json;
}

Json ports_json(const std::vector<PortEnergy>& ports) {
  return list_of(ports, [](const PortEnergy& port) {
    Json json{{"port", port.name},
              {"allowed_j", port.allowed},
              {"given_j", port.given},
              {"net_j", port.net},
              {"active", port.active_at_s.has_value()}};
    if (port.active_at_s) json.update({{"active_at_s", *port.active_at_s}, {"growth_w", port.growth_w}});
    return json;
  });
}

void print_ports(const std::vector<PortEnergy>& ports) {
  const char* title = "energy";
  for (const auto& port : ports) fmt::print("  {:<20}{}\n", std::exchange(title, ""), describe(port));
}

Json networks_json(const std::vector<NetworkReport>& networks) {
  return list_of(networks, [](const NetworkReport& network) -> Json {
    return {{"network", network.name},
            {"file", network.file},
            {"solver", name_of(network.solver)},
            {"oversample", network.oversample},
            {"error_bound", known(network.error_bound())},
            {"error", describe_bound(network)},
            {"ns_per_frame", known(network.ns_per_frame)},
            {"words", describe(network)}};
  });
}

void print_networks(const std::vector<NetworkReport>& networks) {
  for (const auto& network : networks) fmt::print("  {}\n", describe(network));
}

std::string base_of(const std::string& folder, const PlayedScene& played) {
  return (std::filesystem::path{folder} / slug(played.scene.name)).string();
}

ShownPart shown_part(const std::vector<std::string>& times, const PlayedScene& played) {
  const double end_s = played.recording.seconds();
  if (times.empty()) {
    const auto& shown = played.scene.shown;
    const double to_s = std::min(shown.to_s.value_or(end_s), end_s);
    return shown.from_s < to_s ? ShownPart{shown.from_s, to_s} : ShownPart{0, end_s};
  }
  const double from = parse_option(times[0], "s", "show"), to = parse_option(times[1], "s", "show");
  if (from < to && from < end_s) return {from, std::min(to, end_s)};
  exit_with({Errc::OutOfRange, "--show", "this range of time is outside the scene",
             "give a start time before the end of the scene, and a later end time"});
}

std::vector<std::string> write_files(const std::string& folder, const PlayedScene& played,
                                     const PlayedScene* compared, const ShownPart& shown) {
  const auto& recording = played.recording;
  std::error_code ignored;
  std::filesystem::create_directories(folder, ignored);
  const auto base = base_of(folder, played);
  std::vector<std::string> written;
  write_sound(base + "_sound.wav", of_instrument(recording, recording.sounds), played, written);
  const std::pair<const char*, Signals> files[] = {
      {"_drives.wav", of_instrument(recording, drive_names(recording))},
      {"_sensors.wav", of_instrument(recording, recording.inputs)},
      {"_motion.wav", motion_in(played.scene, recording)}};
  for (const auto& [suffix, signals] : files)
    write_signals(base + suffix, signals, recording.sample_rate, written);
  const auto picture = base + ".svg";
  or_exit(write_svg(picture, {scene_plot(played, compared, shown)}));
  written.push_back(picture + fmt::format("  the plot, {:g} s to {:g} s", shown.from_s, shown.to_s));
  return written;
}

}  // namespace tactus::app
