#include "apps/render/render.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "apps/cli/console.h"
#include "apps/study/study.h"
#include "backends/take/replay.h"
#include "engine/core/decibels.h"
#include "engine/core/index.h"
#include "engine/dsp/delays/resample.h"
#include "engine/nodes/table.h"
#include "engine/scene/measures/events.h"

namespace tactus::app {
namespace {

/// The input file at the rate asked for, cut off or followed by silence; without one only silence.
Samples read_input(const RenderOptions& options) {
  const bool file = !options.in.empty();
  auto samples = file ? or_exit(read_wav(options.in)) : Samples{48_kHz, {{}}};
  if (!options.rate.empty()) samples = resample(samples, parse_rate(options.rate));
  if (!(samples.sample_rate.value >= 1e3 && samples.sample_rate.value <= 768e3))
    exit_with({Errc::OutOfRange, options.in, fmt::format("cannot run at {} Hz", samples.sample_rate.value),
               "choose 1 kHz to 768 kHz"});
  if (options.duration.empty() && file) return samples;
  const auto duration =
      options.duration.empty() ? 10_s : parse_duration(options.duration, Seconds{kLongestTime_s});
  if (samples.channels.empty()) samples.channels.emplace_back();
  for (auto& channel : samples.channels)
    channel.resize(static_cast<std::size_t>(frames_in(duration, samples.sample_rate)), 0.0);
  return samples;
}

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

/// Levels count the highest envelope of a hit's first 5 ms.
constexpr double kLevelAfter_s = 5e-3;

/// {"events": [{"time_s", "node", "level_db"}]} from taps "node.output" and "node.level".
Json events_json(const std::vector<std::string>& names, const std::vector<std::vector<double>>& taps,
                 Hertz sample_rate) {
  std::vector<std::pair<double, Json>> events;  // with their times
  for (std::size_t t = 0; t < names.size(); ++t) {
    const auto node = names[t].substr(0, names[t].rfind('.'));
    if (names[t] == node + ".level") continue;
    const auto level = std::find(names.begin(), names.end(), node + ".level");
    const auto times = trigger_times(taps[t], sample_rate);
    for (std::size_t i = 0; i < times.size(); ++i) {
      events.push_back({times[i], {{"time_s", times[i]}, {"node", node}}});
      if (level == names.end()) continue;
      const auto& levels = taps[index(level - names.begin())];
      const double next_s = i + 1 < times.size() ? times[i + 1] : times[i] + kLevelAfter_s;
      const double until_s = std::min(times[i] + kLevelAfter_s, next_s);
      const double highest =
          levels[std::min(levels.size() - 1, static_cast<std::size_t>(until_s * sample_rate.value))];
      if (highest > 0) events.back().second["level_db"] = amplitude_to_db(highest);
    }
  }
  std::stable_sort(events.begin(), events.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  return {{"events", list_of(events, [](const auto& event) { return event.second; })}};
}

Json events_of(const SceneRecording& recording) {
  std::vector<std::string> names;
  std::vector<std::vector<double>> taps;
  const std::string prefix = "instrument.";
  for (const auto& signal : recording.signals) {
    if (!signal.name.starts_with(prefix) || signal.name.find('.', prefix.size()) == std::string::npos)
      continue;
    names.push_back(signal.name.substr(prefix.size()));
    taps.push_back(signal.samples);
  }
  return events_json(names, taps, recording.sample_rate);
}

struct Rendered {
  Samples output;                            ///< a channel for each of `outputs`
  std::vector<std::string> outputs, sounds;  ///< names; of the monitor output
  Json events;
  GuardReport guard;

  std::size_t event_count() const { return events["events"].size(); }
};

Rendered run(Player& engine, const Samples& input, const std::vector<std::string>& taps,
             const DriveBook& drives, int block) {
  const auto& plan = engine.plan();
  Guarded guarded{engine, guarded_channels(plan, drives)};
  Rendered rendered{{input.sample_rate, {}}, output_names(plan), sound_names(plan), {}, {}};
  rendered.output.channels.resize(rendered.outputs.size());
  std::vector<std::vector<double>> tapped(taps.size());
  Progress progress{"rendering"};
  const auto take = [&](const double* const* channels, int count) -> Status {
    for (std::size_t t = 0; t < tapped.size(); ++t)
      tapped[t].insert(tapped[t].end(), engine.tap(static_cast<int>(t)),
                       engine.tap(static_cast<int>(t)) + count);
    for (std::size_t c = 0; c < rendered.outputs.size(); ++c)
      rendered.output.channels[c].insert(rendered.output.channels[c].end(), channels[c], channels[c] + count);
    progress(static_cast<double>(rendered.output.frames()) / static_cast<double>(input.frames()));
    return {};
  };
  or_exit(run_offline(guarded, input, static_cast<int>(rendered.outputs.size()), {block}, take));
  rendered.events = events_json(taps, tapped, input.sample_rate);
  rendered.guard = report_of(guarded, plan, drives);
  return rendered;
}

void write_files(const RenderOptions& options, const Rendered& rendered) {
  const auto& [output, outputs, sounds, events, guard] = rendered;
  if (!options.out.empty()) or_exit(write_wav(options.out, output, options.encoding()));
  if (!options.sound.empty() && sounds.empty())
    exit_with({Errc::BadArgument, "--sound", "this instrument has no monitor output",
               "omit --sound, or give an output the kind \"audio\""});
  Samples monitor{output.sample_rate, {}};
  for (const auto& sound : sounds) {
    const auto place = std::find(outputs.begin(), outputs.end(), sound) - outputs.begin();
    monitor.channels.push_back(output.channels[index(place)]);
  }
  if (!options.sound.empty()) or_exit(write_wav(options.sound, monitor, options.encoding()));
  if (!options.events.empty()) or_exit(write_json(options.events, events));
}

void print(const RenderOptions& options, const std::string& name, const Samples& input, const Player& engine,
           const Rendered& rendered) {
  const auto rate = input.sample_rate;
  const int channels = static_cast<int>(input.channels.size()), inputs = engine.in_channels();
  fmt::print("{}: {:.3f} s at {:g} Hz, {} events\n", name, static_cast<double>(input.frames()) / rate.value,
             rate.value, rendered.event_count());
  if (channels != inputs && !options.in.empty())
    fmt::print("the file has {} channels, the instrument {} inputs: {}\n", channels, inputs,
               channels > inputs ? "only the first channels were used" : "the other inputs were silent");
  if (!options.out.empty()) fmt::print("{}: {}\n", options.out, fmt::join(rendered.outputs, ", "));
  if (!options.sound.empty()) fmt::print("{}: {}\n", options.sound, fmt::join(rendered.sounds, ", "));
  if (!options.events.empty()) fmt::print("{}: the events\n", options.events);
  if (engine.bad_input_samples() > 0)
    fmt::print("{} non-finite input samples replaced by zero\n", engine.bad_input_samples());
  for (const auto& fault : engine.faults())
    fmt::print("fault: {} produced non-finite values {} times\n", fault.path, fault.count);
  if (!rendered.guard.idle()) print_guard(rendered.guard, rate);
}

int render_instrument(const RenderOptions& options, const std::filesystem::path& file) {
  const auto loaded = load_graph_leniently(file, root_of(file));
  if (loaded.spec == nullptr) throw CommandError{loaded.errors};
  const auto input = read_input(options);
  CompileOptions compiling;
  compiling.sample_rate = input.sample_rate;
  compiling.controls = parse_settings(options.set);
  if (!options.delay.empty()) compiling.system_delay = parse_delay(options.delay);
  compiling.taps = event_taps(*loaded.spec, standard_nodes());
  const auto drives = apply(options.guard, {}, root_of(file));
  Player engine{or_exit(compile(loaded, standard_nodes(), compiling))};
  const auto& name = loaded.spec->name;
  if (!options.delay.empty()) announce_delay(*loaded.spec, compiling.system_delay.value);
  const auto rendered = run(engine, input, compiling.taps, drives, options.block.value_or(256));
  write_files(options, rendered);
  if (!options.json) return print(options, name, input, engine, rendered), kDone;
  print_json({{"instrument", name},
              {"sample_rate_hz", input.sample_rate.value},
              {"frames", input.frames()},
              {"outputs", rendered.outputs},
              {"events", rendered.event_count()},
              {"bad_input_samples", engine.bad_input_samples()},
              {"faults", faults_json(engine.faults())},
              {"guard", guard_json(rendered.guard, input.sample_rate)}});
  return kDone;
}

int render_scene(const RenderOptions& options, const std::filesystem::path& file) {
  const auto [scene, recording] = play_file(file, options);
  const auto rate = recording.sample_rate;
  Rendered rendered{{rate, {}}, recording.outputs, recording.sounds, events_of(recording), recording.guard};
  for (const auto& name : recording.outputs)
    rendered.output.channels.push_back(recording.find("instrument." + name)->samples);
  write_files(options, rendered);
  if (options.json) {
    print_json({{"scene", scene.name},
                {"events", rendered.event_count()},
                {"run_seconds", recording.run_seconds},
                {"guard", guard_json(recording.guard, rate)},
                {"ports", ports_json(recording.ports)}});
    return kDone;
  }
  fmt::print("{}: {:.3f} s, {} events, {:.0f} times real time\n", scene.name, recording.seconds(),
             rendered.event_count(), recording.seconds() / recording.run_seconds);
  print_guard(recording.guard, rate);
  print_ports(recording.ports);
  return kDone;
}

std::string error_text(const WorkPrecision& result) {
  const auto& point = result.points.front();
  auto text = fmt::format("{}\n\n", result.scene);
  if (!point.known()) return text + (point.refused ? to_string(*point.refused) : "  unstable") + "\n";
  text += fmt::format("  {:.1f} ns per frame, {:.2g} % of real time at {:g} kHz\n", point.ns_per_frame,
                      100 * point.load(), point.variant.rate.value / 1e3);
  for (std::size_t a = 0; a < point.errors.size(); ++a) {
    const auto& used = result.references[a];
    text += fmt::format(
        "  {:.2e}  relative error of {}: {} of {}, against {}{}\n", point.errors[a], used.accuracy,
        used.measure, used.of, used.what,
        used.own_error > 0 ? fmt::format(", whose own error is at most {:.1e}", used.own_error) : "");
  }
  return text;
}

/// Errors of one run and its time a frame.
int report_accuracy(const RenderOptions& options, const std::filesystem::path& file) {
  auto scene = or_exit(load_scene(file, root_of(file)));
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
  const auto scene_file = resolve_target(options.target, "scene.toml");
  const auto table = load_toml(scene_file);
  const bool scene = table && find(*table, "parts") != nullptr;
  if (options.error) return report_accuracy(options, scene_file);
  if (options.in.empty() && scene) return render_scene(options, scene_file);
  if (scene && !std::filesystem::is_directory(options.target))
    exit_with({Errc::BadArgument, "--in", options.target + " is a scene, which makes its own sensor signals",
               "omit --in, or name the instrument"});
  return render_instrument(options, resolve_target(options.target, "instrument.toml"));
}

}  // namespace

Samples resample(const Samples& samples, Hertz to) {
  if (to == samples.sample_rate) return samples;
  const auto frames = std::llround(static_cast<double>(samples.frames()) / (samples.sample_rate / to));
  Samples result{to, {}};
  for (const auto& channel : samples.channels)
    result.channels.push_back(tactus::resample(channel, samples.sample_rate, to, 0, frames));
  return result;
}

void add_render(CLI::App& app, int& exit_code) {
  auto [command, options] =
      add_command(app, "render", "Run an instrument on a WAV file, or run a scene, without hardware",
                  exit_code, run_render);
  command.add_option(
      "FILE", options.target,
      "instrument or scene file; for a folder, its scene.toml, or its instrument.toml if --in is given");
  command.add_option("--replay", options.replay,
                     "a recording made with --record: replay it and check that the drives match bit for bit; "
                     "with FILE, feed the recorded sensor signals to that instrument");
  command.add_option("--in", options.in,
                     "input WAV file: channel k feeds the k-th input; its rate and duration are "
                     "the defaults; it is resampled if --rate differs");
  command.add_option("--out", options.out, "WAV file for all outputs, in the order of the instrument file")
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
                "report the numerical error and the computing time per frame of a scene that has an "
                "[accuracy] section")
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
