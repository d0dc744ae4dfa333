#include <fmt/format.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "apps/cli/commands.h"
#include "apps/cli/console.h"
#include "apps/cli/writable.h"
#include "apps/play/event_recorder.h"
#include "apps/play/play_report.h"
#include "apps/render/render_error.h"
#include "apps/render/render_take.h"
#include "apps/render/rendered_files.h"
#include "apps/render/resample.h"
#include "backends/offline.h"
#include "engine/graph/file/load.h"
#include "engine/graph/plan/compile.h"
#include "engine/nodes/table.h"
#include "engine/runtime/player.h"
#include "engine/scene/build_scene.h"
#include "engine/scene/guard_report.h"

namespace tactus::app {
namespace {

using Json = nlohmann::ordered_json;

struct RenderOptions {
  std::string target, replay, in, events, rate, delay, duration;
  RenderedFiles files;
  int block = 256;
  std::vector<std::string> set;
  GuardOptions guard;
  bool error = false;
  bool json = false;
};

Result<Samples> read_input(const RenderOptions& options) {
  Samples samples;
  if (!options.in.empty()) {
    auto read = read_wav(options.in);
    if (!read) return read;
    samples = std::move(*read);
    if (!options.rate.empty()) {
      const auto rate = parse_option(options.rate, "Hz", "rate");
      if (!rate) return tl::unexpected(rate.error());
      samples = resample(samples, Hertz{*rate});
    }
  } else {
    const auto rate =
        options.rate.empty() ? Result<double>{48000.0} : parse_option(options.rate, "Hz", "rate");
    if (!rate) return tl::unexpected(rate.error());
    samples.sample_rate = Hertz{*rate};
  }
  if (!(samples.sample_rate.value >= 1e3 && samples.sample_rate.value <= 768e3))
    return fail(Errc::OutOfRange, options.rate.empty() ? options.in : "--rate",
                fmt::format("cannot run at {} Hz", samples.sample_rate.value), "choose 1 kHz to 768 kHz");
  if (!options.duration.empty() || options.in.empty()) {
    const auto duration =
        options.duration.empty() ? Result<double>{10.0} : parse_option(options.duration, "s", "duration");
    if (!duration) return tl::unexpected(duration.error());
    if (!(*duration > 0) || *duration > 86400)
      return fail(Errc::OutOfRange, "--duration", "must be above 0 s and at most a day", "");
    if (samples.channels.empty()) samples.channels.emplace_back();
    for (auto& channel : samples.channels)
      channel.resize(static_cast<std::size_t>(frames_in(Seconds{*duration}, samples.sample_rate)), 0.0);
  }
  return samples;
}

/// A recording must not be lost to its own rendering.
Status check_files(const RenderOptions& options) {
  std::error_code none;
  for (const auto& [option, written] : {std::pair{"--out ", &options.files.out},
                                        {"--sound ", &options.files.sound},
                                        {"--events ", &options.events}})
    if (!written->empty() && !options.in.empty() && std::filesystem::equivalent(*written, options.in, none))
      return fail(Errc::BadArgument, option + *written, "would overwrite what it is made from",
                  "choose another name");
  return {};
}

/// An instrument and what it is run on.
struct InstrumentJob {
  LoadedGraph loaded;
  Samples input;
  CompileOptions compile;
  DriveBook drives;
};

Checked<InstrumentJob> prepare(const RenderOptions& options, const std::filesystem::path& file) {
  const auto failed = [](const Error& error) { return tl::unexpected(std::vector{error}); };
  InstrumentJob job{load_graph_leniently(file, root_of(file)), {}, {}, {}};
  if (job.loaded.spec == nullptr) return tl::unexpected(job.loaded.errors);
  auto input = read_input(options);
  if (!input) return failed(input.error());
  job.input = std::move(*input);
  const auto settings = parse_settings(options.set);
  if (!settings) return failed(settings.error());
  const auto delay = options.delay.empty() ? Result<double>{0.0} : parse_option(options.delay, "s", "delay");
  if (!delay) return failed(delay.error());
  if (*delay < 0 || *delay > 10)
    return failed({Errc::OutOfRange, "--delay", "must be between 0 s and 10 s", ""});
  job.compile.sample_rate = job.input.sample_rate;
  job.compile.controls = *settings;
  job.compile.system_delay = Seconds{*delay};
  job.compile.taps = event_taps(*job.loaded.spec, standard_nodes());
  auto drives = apply(options.guard, {}, root_of(file));
  if (!drives) return tl::unexpected(drives.error());
  job.drives = std::move(*drives);
  return job;
}

/// A finished run of an instrument.
struct InstrumentRun {
  std::string name;
  Samples output{};
  std::vector<std::string> outputs, sounds;  ///< names; see sound_names
  std::int64_t frames = 0, bad_inputs = 0;
  int channels = 0, inputs = 0;  ///< of the file and of the instrument
  Json events{};
  std::vector<FaultCount> faults{};
  GuardReport guard{};
};

Result<InstrumentRun> run_engine(const InstrumentJob& job, Player& engine, int block) {
  const auto& plan = engine.plan();
  Guarded guarded{engine, guarded_channels(plan, job.drives)};
  EventRecorder recorder{engine, job.compile.taps};
  InstrumentRun run{.name = job.loaded.spec->name,
                    .outputs = output_names(plan),
                    .sounds = sound_names(plan),
                    .frames = job.input.frames(),
                    .channels = static_cast<int>(job.input.channels.size()),
                    .inputs = engine.in_channels()};
  run.output.sample_rate = job.input.sample_rate;
  run.output.channels.resize(run.outputs.size());
  Progress progress{"rendering"};
  std::int64_t done = 0;
  const auto take = [&](const double* const* channels, int count) -> Status {
    recorder.take(count);
    for (std::size_t c = 0; c < run.output.channels.size(); ++c)
      run.output.channels[c].insert(run.output.channels[c].end(), channels[c], channels[c] + count);
    done += count;
    progress(static_cast<double>(done) / static_cast<double>(std::max<std::int64_t>(1, run.frames)));
    return {};
  };
  if (auto status = run_offline(guarded, job.input, static_cast<int>(run.outputs.size()), {block}, take);
      !status)
    return tl::unexpected(status.error());
  run.events = recorder.events(job.input.sample_rate);
  run.bad_inputs = engine.bad_input_samples();
  run.faults = engine.faults();
  run.guard = report_of(guarded, plan, job.drives);
  return run;
}

Json json_of(const InstrumentRun& run) {
  Json json{{"instrument", run.name},
            {"sample_rate_hz", run.output.sample_rate.value},
            {"frames", run.frames},
            {"outputs", run.outputs},
            {"events", run.events["events"].size()},
            {"bad_input_samples", run.bad_inputs},
            {"faults", Json::array()}};
  for (const auto& fault : run.faults)
    json["faults"].push_back({{"node", fault.path}, {"count", fault.count}});
  json["guard"] = guard_json(run.guard, run.output.sample_rate);
  return json;
}

void print(const InstrumentRun& run, const RenderOptions& options) {
  const auto rate = run.output.sample_rate;
  fmt::print("{}: {:.3f} s at {:g} Hz, {} events\n", run.name, static_cast<double>(run.frames) / rate.value,
             rate.value, run.events["events"].size());
  if (run.channels != run.inputs && !options.in.empty())
    fmt::print("the file has {} channels and the instrument {} inputs: {}\n", run.channels, run.inputs,
               run.channels > run.inputs ? "the first ones were used" : "the others were silent");
  if (!options.files.out.empty()) fmt::print("{}: {}\n", options.files.out, fmt::join(run.outputs, ", "));
  if (!options.files.sound.empty()) fmt::print("{}: {}\n", options.files.sound, fmt::join(run.sounds, ", "));
  if (!options.events.empty()) fmt::print("{}: the events\n", options.events);
  if (run.bad_inputs > 0) fmt::print("{} non-finite input samples replaced by zero\n", run.bad_inputs);
  for (const auto& fault : run.faults)
    fmt::print("fault: {} gave non-finite values {} times\n", fault.path, fault.count);
  if (!run.guard.idle()) print_guard(run.guard, rate);
}

/// WAV files and events of a run.
Status write(const RenderOptions& options, const Samples& output, const std::vector<std::string>& outputs,
             const std::vector<std::string>& sounds, const Json& events) {
  auto status = write_outputs(options.files, output, outputs, sounds);
  return status && !options.events.empty() ? write_json(options.events, events) : status;
}

int render_instrument(const RenderOptions& options, const std::filesystem::path& file) {
  if (const auto status = check_files(options); !status) return report(status.error());
  auto job = prepare(options, file);
  if (!job) return report(job.error());
  auto schedule = compile(job->loaded, standard_nodes(), job->compile);
  if (!schedule) return report(schedule.error());
  if (!options.delay.empty()) announce_delay(*job->loaded.spec, job->compile.system_delay.value);
  Player engine{std::move(*schedule)};
  const auto run = run_engine(*job, engine, options.block);
  if (!run) return report(run.error());
  if (const auto status = write(options, run->output, run->outputs, run->sounds, run->events); !status)
    return report(status.error());
  if (options.json)
    fmt::print("{}\n", json_of(*run).dump(2));
  else
    print(*run, options);
  return kDone;
}

int render_scene(const RenderOptions& options, const std::filesystem::path& file) {
  SceneRun run;
  run.file = file;
  run.block = options.block;
  run.set = options.set;
  run.delay = options.delay;
  run.rate = options.rate;
  run.duration = options.duration;
  run.guard = options.guard;
  const auto played = play_file(run);
  if (!played) return report(played.error());
  const auto& recording = played->recording;
  const auto events = events_of(*played);
  if (const auto status =
          write(options, outputs_of(*played, recording.outputs), recording.outputs, recording.sounds, events);
      !status)
    return report(status.error());
  if (options.json)
    fmt::print("{}\n", Json{{"scene", played->scene.name},
                            {"events", events["events"].size()},
                            {"run_seconds", played->recording.run_seconds},
                            {"guard", guard_json(played->recording.guard, played->recording.sample_rate)},
                            {"ports", ports_json(played->recording.ports)}}
                           .dump(2));
  else {
    fmt::print("{}: {:.3f} s, {} events, {:.0f} times real time\n", played->scene.name,
               played->recording.seconds(), events["events"].size(),
               played->recording.seconds() / played->recording.run_seconds);
    print_guard(played->recording.guard, played->recording.sample_rate);
    print_ports(played->recording.ports);
  }
  return kDone;
}

int replay(const RenderOptions& options) {
  for (const auto& [text, name] : {std::pair{&options.in, "--in"},
                                   {&options.files.sound, "--sound"},
                                   {&options.events, "--events"},
                                   {&options.rate, "--rate"},
                                   {&options.duration, "--duration"}})
    if (!text->empty())
      return report(Error{Errc::BadArgument, name, "does not go with --replay", "leave one of them out"});
  return render_take({options.replay, options.target, options.files.out, options.files.format, options.block,
                      options.set, options.delay, options.guard, options.json});
}

int run_render(const RenderOptions& options) {
  if (!options.replay.empty()) return replay(options);
  if (options.target.empty())
    return report(
        Error{Errc::Missing, "", "there is nothing to render", "name an instrument, a scene or a take"});
  const auto folder = std::filesystem::is_directory(options.target);
  const auto scene_file = resolve_target(options.target, "scene.toml");
  const auto table = load_toml(scene_file);
  const bool scene = options.in.empty() && table && find(*table, "parts") != nullptr;
  if (options.error)
    return render_error({scene_file, options.rate, options.delay, options.duration, options.json});
  if (scene) return render_scene(options, scene_file);
  if (!folder && table && find(*table, "parts") != nullptr)
    return report(Error{Errc::BadArgument, "--in",
                        options.target + " is a scene, which makes its own sensor signals",
                        "leave --in out, or name the instrument"});
  return render_instrument(options, resolve_target(options.target, "instrument.toml"));
}

}  // namespace

void add_render(CLI::App& app, int& exit_code) {
  auto* command =
      app.add_subcommand("render", "Run an instrument on a WAV file, or a scene, without hardware");
  auto options = std::make_shared<RenderOptions>();
  command->add_option("FILE", options->target,
                      "instrument or scene; a folder means its scene.toml, with --in its instrument.toml");
  command->add_option("--replay", options->replay,
                      "take.wav of --record: replays it and reports whether the drives are the same bit for "
                      "bit; with FILE, plays its sensors on that instrument");
  command->add_option("--in", options->in, "WAV file: channel k goes to the k-th input");
  command->add_option("--out", options->files.out, "WAV file for all outputs, in the order of the file")
      ->check(writable_file());
  command->add_option("--sound", options->files.sound, "WAV file for the monitor output, without the drives")
      ->check(writable_file());
  command
      ->add_option(
          "--events", options->events,
          "JSON file for detected events: {\"events\": [{\"time_s\": …, \"node\": …, \"level_db\": …}]}")
      ->check(writable_file());
  command->add_option("--rate", options->rate, "sample rate; a WAV file is resampled to it");
  command->add_option("--block", options->block, "frames a block (the result does not depend on it)")
      ->check(CLI::Range(1, 4096))
      ->capture_default_str();
  command->add_option("--delay", options->delay, "system delay, such as \"20 ms\"");
  command->add_option("--duration", options->duration, "cut off or continue with silence, such as \"10 s\"");
  command->add_option("--format", options->files.format, "of the WAV files")
      ->check(CLI::IsMember({"float", "24"}))
      ->capture_default_str();
  command->add_option("--set", options->set,
                      "NAME=VALUE: a control, such as strength=0.5 or \"sensitivity=-40 dB\"");
  add_guard_options(*command, options->guard);
  command
      ->add_flag("--error", options->error,
                 "of a scene with [accuracy]: reports its errors and the time of a frame")
      ->excludes("--in", "--out", "--sound", "--events", "--replay", "--set");
  command->add_flag("--json", options->json, "for machines");
  command->footer(
      "Examples:\n  tactus render instruments/haptic_drum --in hits.wav --out drive.wav --events "
      "events.json\n"
      "  tactus render --replay take.wav --out drives.wav\n"
      "  tactus render instruments/cellomobo --sound phrase.wav\n"
      "  tactus render instruments/haptic_drum --delay \"10 ms\" --out drive.wav\n"
      "  tactus render instruments/numerics/woofer --error");
  command->callback([options, &exit_code] { exit_code = run_render(*options); });
}

}  // namespace tactus::app
