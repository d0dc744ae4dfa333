#include <fmt/format.h>

#include "apps/cli/backends.h"
#include "apps/cli/console.h"
#include "apps/cli/json.h"
#include "engine/core/named.h"
#include "engine/core/printable.h"
#include "latency/measured.h"

namespace tactus::app {
namespace {

/// In whatever setting.
const MeasuredDelay* newest_of(const Device& device, const MeasuredDelays& delays) {
  return delays.newest(
      [&](const DelayKey& key) { return key.input == device.id && key.output == device.id; });
}

Json device_json(const Device& device, const MeasuredDelays& delays) {
  Json json{{"id", device.id},
            {"name", device.name},
            {"inputs", device.in_channels},
            {"outputs", device.out_channels},
            {"default_rate_hz", device.default_rate.value},
            {"rates_hz", list_of(device.sample_rates, [](Hertz rate) { return rate.value; })},
            {"default", device.is_default}};
  if (!device.in_names.empty()) json["input_names"] = device.in_names;
  if (!device.out_names.empty()) json["output_names"] = device.out_names;
  if (device.block_frames) json["block_frames"] = *device.block_frames;
  if (device.input_latency_frames) json["driver_input_latency_frames"] = *device.input_latency_frames;
  if (device.output_latency_frames) json["driver_output_latency_frames"] = *device.output_latency_frames;
  if (const auto* measured = newest_of(device, delays)) {
    json["measured_delay_s"] = measured->delay.value;
    json["measured_at"] = measured->when;
  }
  return json;
}

/// With their numbers, as --inputs, --outputs and rigs have them.
void print_channels(const char* direction, const std::vector<std::string>& names) {
  std::vector<std::string> numbered;
  for (const auto& name : names) numbered.push_back(fmt::format("{} {}", numbered.size() + 1, name));
  if (!names.empty()) fmt::print("      {}: {}\n", direction, fmt::join(numbered, ", "));
}

void print(const Device& device, const MeasuredDelays& delays) {
  fmt::print("  {}{}\n", printable(device.id), device.is_default ? "  (default)" : "");
  std::vector<double> rates;
  for (const auto& rate : device.sample_rates) rates.push_back(rate.value / 1e3);
  fmt::print("      {}: {} in, {} out, {}", printable(device.name), device.in_channels, device.out_channels,
             rates.empty() ? fmt::format("{:g} kHz and other rates", device.default_rate.value / 1e3)
                           : fmt::format("{:g} kHz", fmt::join(rates, ", ")));
  if (device.block_frames) fmt::print(", {} frames per block", *device.block_frames);
  const auto ms = [&](const std::optional<double>& frames) {
    return frames ? fmt::format("{:.2f}", 1e3 * *frames / device.default_rate.value) : "?";
  };
  if (device.input_latency_frames || device.output_latency_frames)
    fmt::print(", driver reports {} ms in, {} ms out", ms(device.input_latency_frames),
               ms(device.output_latency_frames));
  if (const auto* measured = newest_of(device, delays))
    fmt::print("\n      measured on this machine: {:.3f} ms, block {} frames, {:g} kHz, {}",
               1e3 * measured->delay.value, measured->key.block_frames, measured->key.sample_rate.value / 1e3,
               measured->when);
  fmt::print("\n");
  print_channels("in ", device.in_names);
  print_channels("out", device.out_names);
}

struct DevicesOptions {
  std::string backend;
  bool json = false;
};

int run_devices(const DevicesOptions& options) {
  const auto& [backend, as_json] = options;
  const auto backends = or_exit(backends_called(backend), backend.empty() ? kDevice : kUsage);
  const auto delays = MeasuredDelays::load();
  if (delays.load_error()) fmt::print(stderr, "{}\n", to_string(*delays.load_error()));
  Json json{{"devices", Json::array()}, {"unavailable", Json::array()}};
  for (const auto& called : backends) {
    const auto devices = called.make()->devices();
    if (!as_json) fmt::print("{}\n", called.name);
    if (!devices) {
      json["unavailable"].push_back(
          {{"backend", called.name}, {"reason", devices.error().what}, {"remedy", devices.error().remedy}});
      if (!as_json) fmt::print("  unavailable: {}\n", to_string(devices.error()));
      continue;
    }
    if (!as_json && devices->empty()) fmt::print("  no device\n");
    for (const auto& device : *devices) {
      json["devices"].push_back(device_json(device, delays));
      if (!as_json) print(device, delays);
    }
  }
  if (as_json) print_json(json);
  return json["devices"].empty() ? kDevice : kDone;
}

}  // namespace

void add_devices(CLI::App& app, int& exit_code) {
  auto [command, options] = add_command(app, "devices", "List the sound devices that instruments can play on",
                                        exit_code, run_devices);
  command.add_option("--backend", options.backend,
                     fmt::format("backend: only its devices; {}, or loop (simulated cards)",
                                 fmt::join(names_of(all_backends()), ", ")));
  command.add_flag("--json", options.json, "print the report as JSON");
  command.footer(
      "Examples:\n  tactus devices\n  tactus devices --backend jack --json\nPass an id, or an unambiguous "
      "part of a device name, to --device:\n  tactus play instruments/haptic_drum --device jack:system\nExit "
      "code 4: no device.");
}

}  // namespace tactus::app
