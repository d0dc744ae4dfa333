#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <optional>

#include "apps/cli/console.h"
#include "apps/cli/take_files.h"
#include "apps/cli/target.h"
#include "apps/render/render.h"
#include "backends/take/replay.h"
#include "engine/core/index.h"
#include "engine/nodes/table.h"
#include "engine/rig/check_rig.h"
#include "engine/rig/rig_inputs.h"
#include "engine/runtime/player.h"

namespace tactus::app {
namespace {

namespace fs = std::filesystem;

/// A rig that does nothing but leave these ports out.
Rig leaving_out(const std::vector<std::string>& ports) {
  Rig rig;
  for (const auto& port : ports) {
    rig.inputs.emplace_back().name = port;
    rig.outputs.emplace_back().name = port;
  }
  return rig;
}

}  // namespace

Checked<std::unique_ptr<Plan>> compile_take(const TakeHeader& header, const TakeFiles& files,
                                            const std::map<std::string, double>& settings) {
  // All versions in one place: a node that plays a sound file is another one if the path is another one.
  static const auto ticks = std::chrono::steady_clock::now().time_since_epoch().count();
  const auto folder = fs::temp_directory_path() / fmt::format("tactus_replay_{}", ticks);
  std::error_code ignored;
  const std::shared_ptr<void> at_end{nullptr, [&](void*) { fs::remove_all(folder, ignored); }};
  const auto file = unpack(files, folder);
  if (!file) return tl::unexpected(std::vector{file.error()});
  auto loaded = load_graph_leniently(*file, folder);
  if (loaded.spec == nullptr) return tl::unexpected(loaded.errors);
  loaded.spec = without_left_out(leaving_out(header.left_out), loaded.spec);
  return compile(loaded, standard_nodes(),
                 {.sample_rate = header.sample_rate,
                  .system_delay = header.system_delay,
                  .controls = {settings.begin(), settings.end()},
                  .taps = header.taps});
}

std::vector<JournalEntry> journal_for(const Take& take, const Player& engine) {
  // Numbers stay; edits only add some.
  const auto& names = take.edits.empty() ? take.header.controls : take.edits.back().controls;
  std::vector<JournalEntry> entries;
  for (auto entry : take.engine) {
    if (entry.kind == JournalEntry::Kind::ControlChange) {
      const auto number = index(entry.index);
      entry.index = number < names.size() ? engine.control_index(names[number]) : -1;
      if (entry.index < 0) continue;
    }
    entries.push_back(entry);
  }
  return entries;
}

std::vector<int> sensors_for(const TakeHeader& header, const std::vector<std::string>& inputs) {
  std::vector<int> sensors;
  for (const auto& input : inputs) {
    const auto found = std::ranges::find(header.inputs, input);
    sensors.push_back(found == header.inputs.end() ? -1 : static_cast<int>(found - header.inputs.begin()));
  }
  return sensors;
}

bool is_same(const Take& take, const Replayed& replayed) {
  return !replayed.first_difference && why_not_exact(take).empty();
}

std::string verdict(const Take& take, const Replayed& replayed) {
  const auto seconds = [&](std::int64_t frame) {
    return static_cast<double>(frame) / take.header.sample_rate.value;
  };
  if (is_same(take, replayed))
    return fmt::format("the drives are identical, bit for bit, for {:.3f} s", seconds(replayed.frames));
  const auto why = why_not_exact(take);
  const auto reason = why.empty() ? "" : fmt::format("this take cannot be replayed bit for bit: {}; ", why);
  if (!replayed.first_difference) return reason + "the recorded part is identical";
  const auto& first = *replayed.first_difference;
  return reason +
         fmt::format("the drives differ from {:.4f} s on (frame {}): '{}' is {:.9g}, recorded {:.9g}",
                     seconds(first.frame), first.frame, take.header.outputs[index(first.channel)],
                     first.replayed, first.recorded);
}

namespace {

/// The scales that the rig gave these sensors.
std::vector<double> scales_for(const TakeHeader& header, const std::vector<int>& sensors) {
  std::vector<double> scales;
  for (const int sensor : sensors) {
    const bool known = sensor >= 0 && sensor < std::ssize(header.input_scales);
    scales.push_back(known ? header.input_scales[index(sensor)] : 1.0);
  }
  return scales;
}

struct OpenTake {
  Take take;
  WavReader wav;
};

Replayed play_into(const RenderOptions& options, OpenTake& open, const ReplayHost& host, StepTimes& times) {
  std::optional<WavWriter> writer;
  if (!options.out.empty())
    writer.emplace(or_exit(
        WavWriter::create(options.out, open.take.header.sample_rate, host.out_channels, options.encoding())));
  Progress progress{"replaying"};
  const auto frames = static_cast<double>(frames_to_replay(open.take, open.wav));
  double done = 0;
  auto replayed = or_exit(replay(open.take, open.wav, host, {options.block.value_or(256)},
                                 [&](const double* const* out, int count) {
                                   times.add(count);
                                   progress((done += count) / frames);
                                   return writer ? writer->write(out, count) : Status{};
                                 }));
  if (writer) or_exit(writer->close());
  return replayed;
}

int timed_every(const OpenTake& open) {
  return tactus::timed_every(static_cast<double>(frames_to_replay(open.take, open.wav)));
}

/// The replay as JSON, with `more`, or as text.
void report(const RenderOptions& options, const OpenTake& open, const Player& engine, const StepTimes& times,
            const Replayed& replayed, const Json& more, const std::string& text) {
  const auto& take = open.take;
  const auto& instrument = engine.plan().name;
  const auto networks = report_networks(engine.plan(), times.ns_per_frame());
  Json json{{"instrument", instrument},  {"sample_rate_hz", take.header.sample_rate.value},
            {"frames", replayed.frames}, {"finished", take.finished},
            {"ended", take.ended},       {"network_solvers", networks_json(networks)}};
  json.update(more);
  if (options.json) return print_json(json);
  fmt::print("{}: {}\n", instrument, text);
  if (!take.finished)
    fmt::print("the recording was cut off; it is complete up to {:.3f} s\n",
               static_cast<double>(frames_to_replay(take, open.wav)) / take.header.sample_rate.value);
  if (!take.ended.empty()) fmt::print("it ended early: {}\n", take.ended);
  if (!options.out.empty()) fmt::print("{}: the drives\n", options.out);
  print_networks(networks);
}

int render_recorded(const RenderOptions& options, OpenTake& open) {
  const auto& header = open.take.header;
  Player engine{or_exit(compile_take(header, header.files, header.settings))};
  engine.set_journal(open.take.engine);
  RigInputs rig{engine, header.input_scales, header.padding_frames};
  Guarded guarded{rig, header.guard, header.armed};
  const auto replace = [&](const TakeEdit& edit) -> Status {
    auto plan = compile_take(header, edit.files, edit.settings);
    if (!plan) return tl::unexpected(plan.error().front());
    return engine.replace(std::move(*plan));
  };
  StepTimes times{engine, timed_every(open)};
  const auto replayed =
      play_into(options, open,
                {guarded, sensors_for(header, header.inputs), engine.out_channels(), replace, true}, times);
  const auto result = verdict(open.take, replayed);
  const bool same = is_same(open.take, replayed);
  Json json{{"same", same}, {"verdict", result}};
  if (const auto& first = replayed.first_difference)
    json["first_difference"] = {{"frame", first->frame}, {"output", first->channel}};
  report(options, open, engine, times, replayed, json, result);
  return same ? kDone : kNo;
}

/// The limits that were recorded, for outputs of the same name.
LimitBook recorded_limits(const TakeHeader& header) {
  LimitBook limits;
  for (std::size_t c = 0; c < std::min(header.guard.size(), header.outputs.size()); ++c) {
    const auto& guard = header.guard[c];
    const bool drive = guard.kind == DriveGuard::Kind::Drive;
    limits.named[header.outputs[c]] = {
        {drive ? LimitSource::Kind::Take : LimitSource::Kind::Ceiling, "the take", guard.limits}};
  }
  return limits;
}

int render_other(const RenderOptions& options, OpenTake& open) {
  const auto& header = open.take.header;
  const auto target = resolve_target(options.target, FolderMeans::Instrument);
  const auto loaded = load_graph_leniently(target.file, target.root());
  const auto delay = options.delay.empty() ? header.system_delay : parse_delay(options.delay);
  Player engine{or_exit(compile(loaded, standard_nodes(),
                                {.sample_rate = header.sample_rate,
                                 .system_delay = delay,
                                 .controls = parse_settings(options.set),
                                 .taps = {}}))};
  engine.set_journal(journal_for(open.take, engine));
  const auto limits = apply(options.guard, recorded_limits(header));
  announce_raises(limits, engine.plan());
  const auto& inputs = engine.plan().input_names;
  const auto sensors = sensors_for(header, inputs);
  RigInputs rig{engine, scales_for(header, sensors), header.padding_frames};
  Guarded guarded{rig, guarded_channels(engine.plan(), limits), header.armed};
  StepTimes times{engine, timed_every(open)};
  const auto replayed = play_into(options, open, {guarded, sensors, engine.out_channels(), {}, false}, times);
  auto text = fmt::format("rendered with the sensor signals of the take, {:.3f} s",
                          static_cast<double>(replayed.frames) / header.sample_rate.value);
  for (std::size_t i = 0; i < inputs.size(); ++i)
    if (sensors[i] < 0) text += fmt::format("\nthe take has no sensor '{}': it was silent", inputs[i]);
  if (!open.take.edits.empty()) text += "\nedits made during the recording are ignored";
  const auto guard = report_of(guarded, engine.plan(), limits);
  report(options, open, engine, times, replayed,
         {{"outputs", output_names(engine.plan())}, {"guard", guard_json(guard, header.sample_rate)}}, text);
  if (!options.json && !guard.idle()) print_guard(guard, header.sample_rate);
  return guard.faded() ? kNo : kDone;
}

}  // namespace

int render_take(const RenderOptions& options) {
  if (options.target.empty() && (!options.set.empty() || !options.delay.empty()))
    exit_with({Errc::BadArgument, "--replay", "a take is replayed with its recorded settings",
               "name an instrument to feed it the recorded sensor signals with other settings"});
  OpenTake open{or_exit(read_take(options.replay)), or_exit(WavReader::open(options.replay))};
  return options.target.empty() ? render_recorded(options, open) : render_other(options, open);
}

}  // namespace tactus::app
