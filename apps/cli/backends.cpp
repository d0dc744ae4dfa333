#include "apps/cli/backends.h"

#include <fmt/format.h>

#include <algorithm>

#include "apps/cli/console.h"
#include "backends/acquisition_backends.h"
#include "backends/described_devices.h"
#include "backends/find_device.h"
#include "backends/library_calls.h"
#include "backends/loop/loop.h"
#include "backends/second_device/two_devices.h"
#include "engine/core/named.h"

namespace tactus::app {

static constexpr const char* kDefaultDevice = "default";  // the first one of the first library

Result<std::vector<BackendType>> backends_called(const std::string& name) {
  on_slow_call([](const std::string& note) { fmt::print(stderr, "{}\n", note); });
  std::vector<BackendType> found;
  if (name == "loop") found = {{name, [] { return std::unique_ptr<Backend>{new LoopBackend}; }}};
  for (const auto& backend : all_backends())
    if (name.empty() || name == backend.name) found.push_back(backend);
  if (!found.empty()) return found;
  const auto remedy = sound_backends().empty()
                          ? "install JACK, RtAudio or PortAudio and build again"
                          : fmt::format("it has {}", fmt::join(names_of(all_backends()), ", "));
  if (!name.empty())
    return fail(Errc::UnknownName, "--backend", "this program was built without the backend '" + name + "'",
                remedy);
  return fail(Errc::Device, "", "this program was built without any library for sound cards", remedy);
}

std::string backend_of(const std::string& device) { return device.substr(0, device.find(':')); }

bool is_haptic(const std::string& backend) { return find_named(haptic_backends(), backend) != nullptr; }

Status check_devices(const Rig::Device& device) {
  const auto& second = device.second;
  const auto backend = backend_of(second);
  if (second.empty()) return {};
  std::string why;
  if (backend == second)
    why = "its id names no backend";
  else if (!backends_called(backend))
    why = "this program was built without the backend '" + backend + "'";
  else if (!is_haptic(backend))
    why = "it is no joystick, wheel or gamepad";
  else if (backend == backend_of(device.output))
    why = "the first device is a joystick, wheel or gamepad too";
  if (why.empty()) return {};
  return fail(
      Errc::BadArgument, device.at.text(),
      fmt::format("second: '{}' cannot be a second device: {}", second, why),
      "name a joystick, wheel or gamepad, such as \"sdl:Xbox Wireless Controller\", beside a sound card");
}

std::string delay_remedy(const std::string& device, const std::string& rig_file) {
  if (is_haptic(backend_of(device)))
    return "estimate its delay: the time between two reports of the device, which tactus play prints, plus 3 "
           "ms";
  return "run tactus latency measure" + (rig_file.empty() ? "" : " --rig " + rig_file);
}

bool has_capacitors(const std::string& backend) {
  return !is_haptic(backend) && find_named(acquisition_backends(), backend) == nullptr;
}

Result<ChosenDevices> choose_devices(const std::string& backend, const std::string& output,
                                     const std::string& input, DeviceNames names) {
  const auto find = [names](const std::vector<Device>& devices, const std::string& text) {
    return names == DeviceNames::Exact ? device_with_id(devices, text) : find_device(devices, text);
  };
  const auto& wanted = output.empty() ? input : output;
  const auto prefix = backend_of(wanted);
  const bool has_prefix = prefix.size() < wanted.size() && backends_called(prefix);
  const auto backends = backends_called(backend.empty() && has_prefix ? prefix : backend);
  if (!backends) return tl::unexpected(backends.error());
  std::vector<Device> others;
  std::vector<std::string> reasons;
  for (const auto& called : *backends) {
    auto made = called.make();
    if (auto* described = dynamic_cast<DescribedDevices*>(made.get()))
      if (auto status = described->add(wanted); !status && status.error().code != Errc::UnknownName)
        return tl::unexpected(status.error());
    const auto devices = made->devices();
    if (!devices || devices->empty()) {
      reasons.push_back(called.name + ": " + (devices ? "no device" : to_string(devices.error())));
      continue;
    }
    auto out = find(*devices, wanted);
    if (!out && out.error().code == Errc::UnknownName) {
      others.insert(others.end(), devices->begin(), devices->end());
      continue;
    }
    if (!out) return tl::unexpected(out.error());
    auto in = input.empty() ? out : find(*devices, input);
    if (!in) return tl::unexpected(in.error());
    return ChosenDevices{std::move(made), std::move(*out), std::move(*in), {}};
  }
  if (const auto missing = find(others, wanted); !others.empty() && !missing)
    return tl::unexpected(missing.error());
  return fail(Errc::Device, "", wanted.empty() ? "no sound device" : "there is no device '" + wanted + "'",
              fmt::format("{}", fmt::join(reasons, "; ")));
}

void add_device_options(CLI::App& command, DeviceOptions& options, const char* rig_help) {
  command.add_option("--rig", options.rig, rig_help);
  command.add_option(
      "--backend", options.backend,
      fmt::format("backend: {}; see tactus devices", fmt::join(names_of(all_backends()), ", ")));
  command.add_option("--device", options.device,
                     fmt::format("id of a device, or part of its name, or {}", kDefaultDevice));
  command.add_option("--input-device", options.input_device, "input device, if different from --device");
}

static void print_chosen(const char* option, const std::string& text, const Device& chosen) {
  if (!text.empty() && text != chosen.id) fmt::print(stderr, "{} {} is {}\n", option, text, chosen.id);
}

ChosenDevices choose_devices(const DeviceOptions& options, const Rig::Device& rig) {
  if (!rig.output.empty()) {
    if (!options.backend.empty())
      exit_with({Errc::BadArgument, "--backend", "cannot be combined with --rig, which names the device",
                 "omit it, or change the rig file"});
    auto chosen = or_exit(choose_devices("", rig.output, rig.input, DeviceNames::Exact), kDevice);
    if (rig.second.empty()) return chosen;
    auto second = or_exit(choose_devices("", rig.second, "", DeviceNames::Exact), kDevice);
    chosen.backend = make_two_devices(std::move(chosen.backend), std::move(second.backend));
    chosen.second = second.output.id;
    return chosen;
  }
  if (!options.backend.empty()) or_exit(backends_called(options.backend), kUsage);
  const auto name = [](const std::string& text) { return text == kDefaultDevice ? std::string{} : text; };
  auto chosen =
      or_exit(choose_devices(options.backend, name(options.device), name(options.input_device)), kDevice);
  print_chosen("--device", options.device, chosen.output);
  print_chosen("--input-device", options.input_device, chosen.input);
  return chosen;
}

StreamRequest request_for(const ChosenDevices& devices, const Rig::Device& rig, const std::string& rate,
                          std::optional<int> block, std::optional<int> periods) {
  StreamRequest request;
  request.device = devices.output.id;
  if (devices.input.id != request.device) request.input_device = devices.input.id;
  request.second_device = devices.second;
  request.sample_rate = rate.empty() ? rig.rate.value_or(devices.output.default_rate) : parse_rate(rate);
  request.block_frames = block ? block : rig.block;
  request.periods = periods ? periods : rig.periods;
  return request;
}

bool has_midi([[maybe_unused]] const std::string& api) {
#if defined(TACTUS_HAS_RTMIDI)
  return true;
#else
  return api == "jack";
#endif
}

std::shared_ptr<MidiInputs> make_midi_inputs(const std::string& api, Backend& backend) {
  if (api == "jack") return backend.midi_inputs(kMidiInterval);
#if defined(TACTUS_HAS_RTMIDI)
  return make_rtmidi(api);
#else
  return nullptr;
#endif
}

}  // namespace tactus::app
