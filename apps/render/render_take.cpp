#include "apps/render/render_take.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <optional>

#include "apps/cli/commands.h"
#include "apps/cli/console.h"
#include "apps/render/replay.h"
#include "engine/nodes/table.h"
#include "engine/scene/guard_report.h"

namespace tactus::app {
namespace {

using Json = nlohmann::ordered_json;

struct OpenTake {
  Take take;
  WavReader wav;
};

Result<OpenTake> open(const std::string& path) {
  auto take = read_take(path);
  if (!take) return tl::unexpected(take.error());
  auto wav = WavReader::open(path);
  if (!wav) return tl::unexpected(wav.error());
  return OpenTake{std::move(*take), std::move(*wav)};
}

/// Plays into the file that was asked for, if any.
Result<Replayed> play_into(const ReplayOptions& options, OpenTake& open, const ReplayHost& host) {
  std::optional<WavWriter> writer;
  if (!options.out.empty()) {
    const auto encoding = options.format == "24" ? WavEncoding::Pcm24 : WavEncoding::Float32;
    auto made = WavWriter::create(options.out, open.take.header.sample_rate, host.out_channels, encoding);
    if (!made) return tl::unexpected(made.error());
    writer.emplace(std::move(*made));
  }
  Progress progress{"replaying"};
  const auto frames = static_cast<double>(frames_to_replay(open.take, open.wav));
  double done = 0;
  auto replayed =
      replay(open.take, open.wav, host, {options.block}, [&](const double* const* out, int count) {
        progress((done += count) / frames);
        return writer ? writer->write(out, count) : Status{};
      });
  if (!replayed || !writer) return replayed;
  if (auto status = writer->close(); !status) return tl::unexpected(status.error());
  return replayed;
}

void print_rest(const ReplayOptions& options, const OpenTake& open) {
  if (!open.take.finished)
    fmt::print(
        "the recording was cut off; it is whole up to {:.3f} s\n",
        static_cast<double>(frames_to_replay(open.take, open.wav)) / open.take.header.sample_rate.value);
  if (!open.take.ended.empty()) fmt::print("it ended early: {}\n", open.take.ended);
  if (!options.out.empty()) fmt::print("{}: the drives\n", options.out);
}

Json take_json(const OpenTake& open, const Replayed& replayed, const std::string& instrument) {
  Json json{{"instrument", instrument},
            {"sample_rate_hz", open.take.header.sample_rate.value},
            {"frames", replayed.frames},
            {"finished", open.take.finished},
            {"ended", open.take.ended}};
  return json;
}

int render_recorded(const ReplayOptions& options, OpenTake& open) {
  const auto& header = open.take.header;
  auto graph = RebuiltGraph::build(header);
  if (!graph) return report(graph.error());
  auto& engine = (*graph)->engine();
  engine.set_journal(open.take.engine);
  Guarded guarded{(*graph)->processor(), header.guard, header.armed};
  const auto replace = [&](const TakeEdit& edit) { return (*graph)->replace(edit); };
  const ReplayHost host{guarded, sensors_for(header, header.inputs), engine.out_channels(), replace, true};
  const auto replayed = play_into(options, open, host);
  if (!replayed) return report(replayed.error());
  const auto words = verdict(open.take, *replayed);
  const bool same = is_same(open.take, *replayed);
  if (options.json) {
    auto json = take_json(open, *replayed, (*graph)->name());
    json["same"] = same;
    json["verdict"] = words;
    if (const auto& first = replayed->first_difference)
      json["first_difference"] = {{"frame", first->frame}, {"output", first->channel}};
    fmt::print("{}\n", json.dump(2));
    return same ? kDone : kNo;
  }
  fmt::print("{}: {}\n", (*graph)->name(), words);
  print_rest(options, open);
  return same ? kDone : kNo;
}

/// The limits that were recorded, for outputs of the same name.
DriveBook recorded_drives(const TakeHeader& header) {
  DriveBook drives;
  for (std::size_t c = 0; c < std::min(header.guard.size(), header.outputs.size()); ++c)
    if (header.guard[c].kind == DriveGuard::Kind::Drive)
      drives.named[header.outputs[c]] = header.guard[c].limits;
  return drives;
}

int render_other(const ReplayOptions& options, OpenTake& open) {
  const auto& header = open.take.header;
  const auto file = resolve_target(options.target, "instrument.toml");
  const auto loaded = load_graph_leniently(file, root_of(file));
  if (loaded.spec == nullptr) return report(loaded.errors);
  const auto settings = parse_settings(options.set);
  if (!settings) return report(settings.error());
  const auto delay = options.delay.empty() ? Result<double>{header.system_delay.value}
                                           : parse_option(options.delay, "s", "delay");
  if (!delay) return report(delay.error());
  CompileOptions compile_options;
  compile_options.sample_rate = header.sample_rate;
  compile_options.system_delay = Seconds{*delay};
  compile_options.controls = *settings;
  auto schedule = compile(loaded, standard_nodes(), compile_options);
  if (!schedule) return report(schedule.error());
  Player engine{std::move(*schedule)};
  engine.set_journal(journal_for(open.take, engine));
  const auto drives = apply(options.guard, recorded_drives(header), root_of(file));
  if (!drives) return report(drives.error());
  const auto& inputs = engine.plan().input_names;
  const auto sensors = sensors_for(header, inputs);
  RigInputs rig{engine, scales_for(header, sensors), header.padding_frames};
  Guarded guarded{rig, guarded_channels(engine.plan(), *drives), header.armed};
  const ReplayHost host{guarded, sensors, engine.out_channels(), {}, false};
  const auto replayed = play_into(options, open, host);
  if (!replayed) return report(replayed.error());
  if (options.json) {
    auto json = take_json(open, *replayed, loaded.spec->name);
    json["outputs"] = output_names(engine.plan());
    fmt::print("{}\n", json.dump(2));
    return kDone;
  }
  fmt::print("{}: played the sensors of the take for {:.3f} s\n", loaded.spec->name,
             static_cast<double>(replayed->frames) / header.sample_rate.value);
  for (std::size_t i = 0; i < inputs.size(); ++i)
    if (sensors[i] < 0) fmt::print("the take has no sensor '{}': it was silent\n", inputs[i]);
  if (!open.take.edits.empty()) fmt::print("edits that were made while it was recorded are left out\n");
  print_rest(options, open);
  return kDone;
}

}  // namespace

int render_take(const ReplayOptions& options) {
  std::error_code none;
  if (!options.out.empty() && std::filesystem::equivalent(options.out, options.take, none))
    return report(
        Error{Errc::BadArgument, "--out " + options.out, "would overwrite the take", "choose another name"});
  if (options.target.empty() && (!options.set.empty() || !options.delay.empty()))
    return report(Error{Errc::BadArgument, "--replay",
                        "a take is played with the settings that it was recorded with",
                        "name an instrument to play its sensors with other settings"});
  auto opened = open(options.take);
  if (!opened) return report(opened.error());
  return options.target.empty() ? render_recorded(options, *opened) : render_other(options, *opened);
}

}  // namespace tactus::app
