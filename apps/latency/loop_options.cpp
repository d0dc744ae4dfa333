#include "apps/latency/loop_options.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "apps/cli/commands.h"
#include "apps/cli/interrupts.h"
#include "apps/latency/latency_files.h"
#include "engine/core/decibels.h"
#include "engine/graph/file/quantity.h"

namespace tactus::app {
namespace {

namespace fs = std::filesystem;
tl::unexpected<CommandError> refuse(Error error, int exit = kUsage) {
  return tl::unexpected(CommandError{{std::move(error)}, exit});
}

/// Options that the rig sets and the command line may not override.
Status check_against_rig(const LoopOptions& options) {
  for (const auto& [given, option] : {std::pair{!options.device.empty(), "--device"},
                                      {!options.input_device.empty(), "--input-device"},
                                      {!options.rate.empty(), "--rate"},
                                      {options.block.has_value(), "--block"},
                                      {options.periods.has_value(), "--periods"}})
    if (given)
      return fail(Errc::BadArgument, option, "cannot be combined with --rig, which sets it",
                  "change the rig file: its measured delay is valid for its own settings only");
  return {};
}

/// The folder with the profiles that a rig names: the instruments beside it, or beside the current folder.
fs::path profiles_near(const fs::path& rig_file) {
  std::error_code ignored;
  const auto beside = fs::absolute(rig_file, ignored).parent_path();
  for (const auto& start : {beside, fs::current_path(ignored)})
    for (auto folder = start;; folder = folder.parent_path()) {
      for (const auto& root : {folder, folder / "instruments"})
        if (fs::is_directory(root / "profiles", ignored)) return root;
      if (!folder.has_relative_path()) break;
    }
  return beside;
}

template <class Ports>
int first_channel(const Ports& ports) {
  for (const auto& port : ports)
    if (!port.channels.empty()) return port.channels.front();
  return 1;
}

/// What is connected to an output, from 1, as far as the rig has it; nullptr: nothing.
const RigOutput* port_on(const Rig& rig, int channel) {
  if (const auto* actuator = rig.actuator_on(channel)) return actuator;
  for (const auto& output : rig.outputs)
    if (std::count(output.channels.begin(), output.channels.end(), channel) > 0) return &output;
  return nullptr;
}

/// The guard of the output from the rig; else a cable, with the level as its ceiling.
GuardedChannel guard_of(const Rig* rig, int output, double loudest_dbfs) {
  const auto* port = rig == nullptr ? nullptr : port_on(*rig, output);
  if (port != nullptr) return {DriveGuard::Kind::Drive, port->drive.limits};
  GuardedChannel guard{DriveGuard::Kind::Audio, {}};
  guard.limits.ceiling = amplitude_from_db(loudest_dbfs);
  return guard;
}

Status check_channel(int channel, int there, const Device& device, const char* option) {
  if (channel <= there) return {};
  const std::string kind = option[2] == 'i' ? "input" : "output";
  if (there == 0)
    return fail(Errc::OutOfRange, option, fmt::format("'{}' has no {}s", device.id, kind),
                fmt::format("choose a device that has some with --{}device; see tactus devices",
                            kind == "input" ? "input-" : ""));
  return fail(Errc::OutOfRange, option, fmt::format("'{}' has no {} {}", device.id, kind, channel),
              fmt::format("it has channels 1 to {}", there));
}

Status set_request(const LoopOptions& options, Loop& loop) {
  const auto device = loop.rig ? loop.rig->device : Rig::Device{};
  auto& request = loop.settings.request;
  request.device = loop.devices.output.id;
  if (loop.devices.input.id != request.device) request.input_device = loop.devices.input.id;
  request.block_frames = loop.rig ? device.block : options.block;
  request.periods = loop.rig ? device.periods : options.periods;
  request.sample_rate = device.rate ? device.rate : loop.devices.output.default_rate;
  if (options.rate.empty()) return {};
  return parse_rate(options.rate, "rate").map([&](Hertz rate) { request.sample_rate = rate; });
}

Status set_channels(const LoopOptions& options, Loop& loop) {
  const int input = options.input.value_or(loop.rig ? first_channel(loop.rig->inputs) : 1);
  const int output = options.output.value_or(loop.rig ? first_channel(loop.rig->outputs) : 1);
  loop.settings.input = input - 1;
  loop.settings.output = output - 1;
  const auto& devices = loop.devices;
  const auto status = check_channel(input, devices.input.in_channels, devices.input, "--in");
  return status ? check_channel(output, devices.output.out_channels, devices.output, "--out") : status;
}

Status set_level(const LoopOptions& options, Loop& loop) {
  auto& settings = loop.settings;
  if (!options.level.empty()) {
    const auto level = parse_level(options.level, "level");
    if (!level) return tl::unexpected(level.error());
    settings.loudest_dbfs = *level;
  }
  settings.guard = guard_of(loop.rig ? &*loop.rig : nullptr, settings.output + 1, settings.loudest_dbfs);
  settings.loudest_dbfs = std::min(settings.loudest_dbfs, amplitude_to_db(settings.guard.limits.ceiling));
  settings.softest_dbfs = std::min(settings.softest_dbfs, settings.loudest_dbfs);
  return {};
}

struct Interrupted {};

}  // namespace

void add_loop_options(CLI::App& command, LoopOptions& options) {
  command.add_option("--backend", options.backend, "audio backend: jack, rtaudio, …; see tactus devices");
  command.add_option("--device", options.device, "id of a device, or part of its name");
  command.add_option("--input-device", options.input_device, "input device, if different from --device");
  command.add_option("--rig", options.rig,
                     "rig file: device, sample rate, block size and what is connected to the output; the "
                     "measured delay is saved there");
  command.add_option("--in,--input", options.input, "input channel of the loop, counted from 1")
      ->check(CLI::Range(1, 1024));
  command.add_option("--out,--output", options.output, "output channel of the loop, counted from 1")
      ->check(CLI::Range(1, 1024));
  command.add_option("--level", options.level,
                     "highest peak level to play, such as \"-20 dBFS\"; default: -6 dBFS");
}

void add_setting_options(CLI::App& command, LoopOptions& options) {
  command.add_option("--rate", options.rate, "sample rate; default: the device's");
  command.add_option("--block", options.block, "block size in frames; default: the device's")
      ->check(CLI::Range(1, 8192));
  command.add_option("--periods", options.periods, "blocks in the driver's buffer")->check(CLI::Range(1, 64));
}

void add_repetition_options(CLI::App& command, LoopOptions& options) {
  command.add_option("--openings", options.openings, "number of times the stream is opened")
      ->check(CLI::Range(1, 100))
      ->capture_default_str();
  command
      .add_option("--sweeps", options.probes, "number of probe signals played each time the stream is opened")
      ->check(CLI::Range(2, 100))
      ->capture_default_str();
}

tl::expected<Loop, CommandError> make_loop(const LoopOptions& options) {
  Loop loop;
  loop.settings.openings = options.openings;
  loop.settings.probes = options.probes;
  if (!options.rig.empty()) {
    if (auto status = check_against_rig(options); !status) return refuse(status.error());
    auto rig = load_rig(options.rig, profiles_near(options.rig));
    if (!rig) return tl::unexpected(CommandError{std::move(rig.error()), kBadFile});
    loop.rig = std::move(*rig);
  }
  auto devices = choose_devices(options.backend, loop.rig ? loop.rig->device.output : options.device,
                                loop.rig ? loop.rig->device.input : options.input_device);
  if (!devices)
    return refuse(devices.error(), devices.error().place == Error::Place::Option ? kUsage : kDevice);
  loop.devices = std::move(*devices);
  for (const auto set : {set_request, set_channels, set_level})
    if (auto status = set(options, loop); !status) return refuse(status.error());
  if (options.profile.empty()) return loop;
  auto profile = read_profile(options.profile, *loop.settings.request.sample_rate);
  if (!profile) return refuse(profile.error(), kBadFile);
  loop.settings.profile = std::move(*profile);
  return loop;
}

Result<std::optional<Measurement>> measure_now(Backend& backend, const MeasureSettings& settings) {
  Progress bar{"measuring"};
  try {
    auto measured = measure(backend, settings, [&](double share, const std::string& what) {
      if (interrupted()) throw Interrupted{};  // the stream ends with its owner, with a block of zeros
      bar(share, what);
    });
    if (!measured) return tl::unexpected(measured.error());
    return std::optional{std::move(*measured)};
  } catch (const Interrupted&) {
    return std::optional<Measurement>{};
  }
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

Result<double> parse_level(const std::string& text, const char* option) {
  const auto where = std::string{"--"} + option;
  const auto value = read_quantity(Value{text.ends_with("FS") ? text.substr(0, text.size() - 2) : text, {}});
  if (!value || !(value->bare || value->unit.decibel))
    return fail(Errc::Syntax, where, "'" + text + "' is not a level", "write for instance \"-20 dBFS\"");
  const double level = value->bare ? value->si : value->unit.from_si(value->si);
  if (level >= -120 && level <= 0) return level;
  return fail(Errc::OutOfRange, where, "must be between -120 and 0 dBFS", "write for instance \"-20 dBFS\"");
}

Result<Hertz> parse_rate(const std::string& text, const char* option) {
  const auto rate = parse_option(text, "Hz", option);
  if (!rate) return tl::unexpected(rate.error());
  if (*rate >= 1000 && *rate <= 1e6) return Hertz{*rate};
  return fail(Errc::OutOfRange, std::string{"--"} + option, "must be between 1 kHz and 1 MHz",
              "write for instance \"48 kHz\"");
}

}  // namespace tactus::app
