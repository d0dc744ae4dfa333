#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "apps/cli/rig_files.h"
#include "apps/cli/stop_loop.h"
#include "apps/latency/latency.h"
#include "engine/core/decibels.h"
#include "engine/dsp/delays/resample.h"
#include "engine/graph/file/quantity.h"
#include "engine/scene/file/path_file.h"

namespace tactus::app {
namespace {

/// Options that the rig sets and the command line may not override.
void check_against_rig(const LoopOptions& options) {
  for (const auto& [given, option] : {std::pair{!options.backend.empty(), "--backend"},
                                      {!options.device.empty(), "--device"},
                                      {!options.input_device.empty(), "--input-device"},
                                      {!options.rate.empty(), "--rate"},
                                      {options.block.has_value(), "--block"},
                                      {options.periods.has_value(), "--periods"}})
    if (given)
      exit_with({Errc::BadArgument, option, "cannot be combined with --rig, which sets it",
                 "change the rig file: its measured delay is valid for its own settings only"});
}

template <class Ports>
int first_channel(const Ports& ports) {
  for (const auto& port : ports)
    if (!port.channels.empty() && !port.on_second_device()) return port.channels.front();
  return 1;
}

/// Does the rig say what is connected to this output, from 1?
bool is_known(const std::optional<Rig>& rig, int output) {
  const auto uses = [output](const RigPort& port) { return port.uses(output); };
  return rig && (std::ranges::any_of(rig->actuators, uses) || std::ranges::any_of(rig->outputs, uses));
}

/// A drive, whatever it is, unless the user says that only a cable is there.
GuardedChannel guard_of(const LoopOptions& options, const std::optional<Rig>& rig, int output,
                        double loudest_dbfs) {
  const bool known = is_known(rig, output);
  if (known && options.cable)
    exit_with({Errc::BadArgument, "--cable",
               fmt::format("the rig says what is connected to output {}, and its limits hold", output),
               "omit --cable, or measure with --device instead of --rig"});
  if (!known && !options.cable)
    fmt::print(stderr,
               "note: it is not known what is connected to output {}: it is guarded as a drive with the "
               "conservative limits; give --cable if it is a loopback cable only, or --rig\n",
               output);
  auto sources = rig ? rig->limit_sources(output) : std::vector<LimitSource>{};
  sources.push_back(
      {LimitSource::Kind::Ceiling, "--level", DriveLimits{.ceiling = amplitude_from_db(loudest_dbfs)}});
  return combine_limits(options.cable ? OutputTarget::Sound : OutputTarget::Drive, sources);
}

void check_channel(int channel, int there, const Device& device, const char* option) {
  if (channel <= there) return;
  const bool input = option[2] == 'i';
  exit_with({Errc::OutOfRange, option,
             fmt::format("'{}' has no {} {}", device.id, input ? "input" : "output", channel),
             there > 0 ? fmt::format("it has channels 1 to {}", there)
                       : fmt::format("choose a device that has some with --{}; see tactus devices",
                                     input ? "input-device" : "device")});
}

void set_channels(const LoopOptions& options, Loop& loop) {
  const int input = options.input.value_or(loop.rig ? first_channel(loop.rig->inputs) : 1);
  const int output = options.output.value_or(loop.rig ? first_channel(loop.rig->outputs) : 1);
  loop.settings.input = input - 1;
  loop.settings.output = output - 1;
  const auto& devices = loop.devices;
  check_channel(input, devices.input.in_channels, devices.input, "--input");
  check_channel(output, devices.output.out_channels, devices.output, "--output");
}

void set_level(const LoopOptions& options, Loop& loop) {
  auto& settings = loop.settings;
  if (!options.level.empty()) settings.loudest_dbfs = parse_level(options.level);
  settings.guard = guard_of(options, loop.rig, settings.output + 1, settings.loudest_dbfs);
  settings.watch_sensors = is_known(loop.rig, settings.output + 1);
  settings.loudest_dbfs = std::min(settings.loudest_dbfs, amplitude_to_db(settings.guard.limits.ceiling));
  settings.softest_dbfs = std::min(settings.softest_dbfs, settings.loudest_dbfs);
}

}  // namespace

void add_loop_options(CLI::App& command, LoopOptions& options, bool setting, bool repetitions) {
  add_device_options(command, options,
                     "rig file: device, sample rate, block size and what is connected to the output; "
                     "latency measure saves the delay there");
  add_number(command, "--input", options.input, "input channel of the loop, counted from 1", 1, 1024);
  add_number(command, "--output", options.output, "output channel of the loop, counted from 1", 1, 1024);
  command.add_option("--level", options.level, "highest peak level; such as \"-20 dBFS\"; default: -6 dBFS");
  command.add_flag("--cable", options.cable,
                   "nothing but a loopback cable is connected to the output: play up to --level, without the "
                   "conservative limits of a drive");
  command.add_flag("--shared-port", options.shared_port,
                   "another program may write to the ports of drives too: no guard limits the sum");
  if (setting) {
    command.add_option("--rate", options.rate, "sample rate; default: the device's");
    add_number(command, "--block", options.block, "block size in frames; default: the device's", 1, 8192);
    add_number(command, "--periods", options.periods, "blocks in the driver's buffer", 1, 64);
  }
  if (!repetitions) return;
  add_number(command, "--openings", options.openings, "number of times the stream is opened", 1, 100);
  add_number(command, "--probes", options.probes,
             "number of probe signals (sine sweeps) played each time the stream is opened", 2, 100);
}

Loop make_loop(const LoopOptions& options) {
  accept_stop_signals();
  Loop loop;
  auto& settings = loop.settings;
  settings.openings = options.openings;
  settings.probes = options.probes;
  settings.shared_port = options.shared_port;
  if (!options.rig.empty()) {
    check_against_rig(options);
    loop.rig = open_rig(options.rig);
  }
  const auto device = loop.rig ? loop.rig->device : Rig::Device{};
  const auto refuse_haptic = [&](const std::string& id) {
    if (is_haptic(backend_of(id)))
      exit_with({Errc::BadArgument, loop.rig ? device.at.text() : "--device",
                 "'" + id + "' is no sound card, and plays no probe", delay_remedy(id, options.rig)});
  };
  refuse_haptic(loop.rig ? device.output : options.device);  // whether it is connected or not
  loop.devices = choose_devices(options, device);
  refuse_haptic(loop.devices.output.id);  // of a part of its name
  settings.request = request_for(loop.devices, device, options.rate, options.block, options.periods);
  set_channels(options, loop);
  set_level(options, loop);
  if (!options.profile.empty())
    settings.profile = read_profile(options.profile, *settings.request.sample_rate);
  return loop;
}

const Error kInputClosed{Errc::BadArgument, "",
                         "standard input was closed, so that no key could end the measurement: ended",
                         "add </dev/null to measure without keys"};

Result<Measurement> measure_now(Backend& backend, MeasureSettings settings, bool another_follows) {
  DeadMansSwitch dead_man;
  StopLoop stop_loop{dead_man,
                     {.act = {},
                      .needs_input = [] { return true; },
                      .inputs = {},
                      .fade = closing_time(settings.guard.limits)}};
  settings.dead_mans_switch = &dead_man;
  Progress bar{"measuring"};
  auto measured = measure(backend, settings, [&](double share, const std::string& what) {
    // The output fades; the stream ends with its owner.
    const auto ending = stop_loop.ending();
    if (ending == StopLoop::Ending::InputClosed) throw CommandError{{kInputClosed}, kInterrupted};
    if (interrupted() || ending != StopLoop::Ending::None) throw CommandError{{}, kInterrupted};
    bar(share, what);
  });
  if (another_follows)
    if (const auto attended = check_attended(dead_man); !attended)
      throw CommandError{{attended.error()}, kDevice};
  return measured;
}

PathProfile read_profile(const std::string& file, Hertz sample_rate) {
  const auto path = or_exit(read_path(load_graph_leniently(file)), kBadFile);
  return {sample_rate, taps_at_rate(path.taps, path.rate, sample_rate), {}, {}};
}

std::string source_text(const MeasureSettings& settings, const StreamGranted& granted) {
  const auto& wanted = settings.request;
  auto text = granted.device;
  if (!granted.input_device.empty()) text += " and " + granted.input_device;
  text += fmt::format(", {:g} kHz, ", granted.format.sample_rate.value / 1e3);
  text +=
      granted.block_frames > 0 ? fmt::format("{} frames per block", granted.block_frames) : "changing blocks";
  if (wanted.block_frames && *wanted.block_frames != granted.block_frames)
    text += fmt::format(" ({} requested)", *wanted.block_frames);
  if (granted.periods > 0) text += fmt::format(", {} periods", granted.periods);
  return text + fmt::format("; output {} to input {}", settings.output + 1, settings.input + 1);
}

double parse_level(const std::string& text) {
  const auto value = read_quantity(Value{text.ends_with("FS") ? text.substr(0, text.size() - 2) : text, {}});
  if (!value || !(value->bare || value->unit.decibel))
    exit_with({Errc::Syntax, "--level", "'" + text + "' is not a level", "write for instance \"-20 dBFS\""});
  const double level = value->bare ? value->si : value->unit.from_si(value->si);
  if (level >= -120 && level <= 0) return level;
  exit_with(
      {Errc::OutOfRange, "--level", "must be between -120 and 0 dBFS", "write for instance \"-20 dBFS\""});
}

}  // namespace tactus::app
