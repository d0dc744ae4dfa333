#include "backends/find_device.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <map>
#include <set>

#include "backends/alsa_devices.h"
#include "backends/jack_names.h"
#include "engine/core/index.h"

namespace tactus {
namespace {

constexpr int kMaxBlock = 8192;

std::string lower_case(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

std::string listed(const std::vector<Device>& devices) {
  std::string text;
  for (const auto& device : devices) text += (text.empty() ? "'" : ", '") + device.id + "'";
  return text;
}

std::string with_hardware(const std::string& id, const std::string& hardware) { return id + "@" + hardware; }

/// The program that has this direction of an ALSA card's device open: "hw:USB Audio,0" of RtAudio,
/// "USB Audio: - (hw:1,0)" of PortAudio. Empty: none.
std::string user_of(const Device& device, bool inputs) {
  const auto comma = device.library_name.rfind(',');
  int number = 0;
  if (device.api != "alsa" || comma == std::string::npos ||
      std::sscanf(device.library_name.c_str() + comma, ",%d", &number) != 1)
    return {};
  for (const auto& pcm : alsa_devices())
    if (pcm.device == number && (device.hardware + ",").starts_with(pcm.hardware + ","))
      return alsa_user(pcm.card, number, inputs);
  return {};
}

Status fits(int channels, const std::vector<int>& map, bool inputs, const Device& device) {
  const auto at = "'" + device.id + "'";
  const auto* what = inputs ? "inputs" : "outputs";
  const int available = inputs ? device.in_channels : device.out_channels;
  if (channels < 0)
    return fail(Errc::BadArgument, "", fmt::format("there cannot be {} {}", channels, what), "");
  if (!map.empty() && map.size() != index(channels))
    return fail(Errc::BadArgument, "",
                fmt::format("{} {} of the device are chosen, but {} are needed", map.size(), what, channels),
                "choose one for each");
  const int last = channels_to_open(channels, map);
  if (last > available)
    if (const auto user = user_of(device, inputs); !user.empty())
      return fail(Errc::Device, "", fmt::format("the {} of {} are in use by {}", what, at, user),
                  "end that program, or choose another device");
  if (last > available || (!map.empty() && *std::min_element(map.begin(), map.end()) < 0))
    return fail(
        Errc::OutOfRange, "",
        fmt::format("{} has {} {}, but number {} is requested", at, available, what, last),
        available == 0 ? "choose another device" : fmt::format("choose channels from 1 to {}", available));
  return {};
}

Status fits(const StreamRequest& request, const Device& device) {
  if (!request.sample_rate) return {};
  const double rate = request.sample_rate->value;
  const auto& rates = device.sample_rates;
  if (std::count(rates.begin(), rates.end(), *request.sample_rate) > 0) return {};
  const bool is_sound_card = std::ranges::none_of(rates, [](Hertz each) { return each < 8_kHz; });
  if (is_sound_card && !(std::isfinite(rate) && rate >= 8e3 && rate <= 192e3))
    return fail(Errc::OutOfRange, "", fmt::format("{} Hz is not a sample rate of sound cards", rate),
                "choose 8 kHz to 192 kHz");
  if (rates.empty()) return {};
  std::string text;
  for (const auto& supported : rates)
    text += fmt::format("{}{:g}", text.empty() ? "" : ", ", supported.value);
  return fail(Errc::BadArgument, "", fmt::format("'{}' does not run at {:g} Hz", device.id, rate),
              "it runs at " + text + " Hz; omit the rate, or set the device to another rate");
}

Status fits(const StreamRequest& request, const Device& input, const Device& output) {
  if (auto status = fits(request.in_channels, request.in_map, true, input); !status) return status;
  if (auto status = fits(request.out_channels, request.out_map, false, output); !status) return status;
  if (const std::set<int> used{request.out_map.begin(), request.out_map.end()};
      used.size() != request.out_map.size())
    return fail(Errc::BadArgument, "", "two outputs share a channel, where they would be added",
                "give each output its own channel");
  if (request.block_frames && (*request.block_frames < 1 || *request.block_frames > kMaxBlock))
    return fail(Errc::OutOfRange, "", fmt::format("a block cannot have {} frames", *request.block_frames),
                fmt::format("choose 1 to {}", kMaxBlock));
  if (request.periods && (*request.periods < 1 || *request.periods > 64))
    return fail(Errc::OutOfRange, "", fmt::format("a buffer cannot have {} periods", *request.periods),
                "choose 2 or 3");
  if (auto status = fits(request, input); !status) return status;
  return fits(request, output);
}

}  // namespace

std::string two_devices_text(const Device& input, const Device& output, std::pair<int, int> channels,
                             double rate) {
  return fmt::format(
      "{} inputs of '{}' and {} outputs of '{}' cannot be opened together at {:g} Hz, nor with the same "
      "number of channels",
      channels.first, input.id, channels.second, output.id, rate);
}

int channels_to_open(int channels, const std::vector<int>& map) {
  return map.empty() ? channels : *std::max_element(map.begin(), map.end()) + 1;
}

Result<Device> device_with_id(const std::vector<Device>& devices, const std::string& id,
                              const std::string& hardware) {
  const auto remedy =
      devices.empty()
          ? std::
                string{"no device was found; check that it is connected and that the sound server is running"}
          : "there is " + listed(devices);
  const auto chosen = [&](const Device& device) {
    if (id.empty()) return device.is_default;
    return device.id == id || (!device.hardware.empty() && with_hardware(device.id, device.hardware) == id);
  };
  if (const auto found = std::find_if(devices.begin(), devices.end(), chosen); found != devices.end())
    return *found;
  if (!id.empty() && !hardware.empty() && !id.ends_with(with_hardware("", hardware)))
    return device_with_id(devices, with_hardware(id, hardware));
  if (is_left_out(id, devices))
    return fail(
        Errc::UnknownName, "",
        "there is no device '" + id +
            "' that can be opened here: RtAudio and PortAudio take a JACK client's name for a regular "
            "expression, and would open the ports of another client",
        "use --backend jack");
  return fail(
      Errc::UnknownName, "", id.empty() ? "there is no default device" : "there is no device '" + id + "'",
      // It may be there, and its name in that of another client's port.
      is_jack_client_of_library(id) ? remedy + "; or use --backend jack, which opens every client" : remedy);
}

Result<Device> find_device(const std::vector<Device>& devices, const std::string& text) {
  auto exact = device_with_id(devices, text);
  if (exact || text.empty()) return exact;
  // The whole id of a JACK client that was left out is no part of the name of the one that it matches.
  if (is_jack_client_of_library(text) && is_left_out(text, devices)) return exact;
  std::vector<Device> meant;
  std::copy_if(devices.begin(), devices.end(), std::back_inserter(meant), [&](const Device& device) {
    return lower_case(device.id + "\n" + device.name).find(lower_case(text)) != std::string::npos;
  });
  if (meant.size() == 1) return meant.front();
  if (meant.empty()) return exact;
  return fail(Errc::BadArgument, "", "'" + text + "' matches several devices",
              "write one of " + listed(meant));
}

Result<DeviceChoice> choose(const std::vector<Device>& devices, const StreamRequest& request) {
  if (request.in_channels == 0 && request.out_channels == 0)
    return fail(Errc::BadArgument, "", "a stream needs at least one input or output", "request a channel");
  const auto at_input = request.input_device.empty() ? request.device : request.input_device;
  const auto before = request.previous.value_or(StreamGranted{});
  const auto to_input = [&] { return device_with_id(devices, at_input, before.input.hardware); };
  auto output = request.out_channels == 0 ? to_input()
                                          : device_with_id(devices, request.device, before.output.hardware);
  auto input = request.in_channels == 0 ? output : to_input();
  if (!output) return tl::unexpected(with_alsa_users(output.error()));
  if (!input) return tl::unexpected(with_alsa_users(input.error()));
  if (request.out_channels == 0) output = input;
  auto asked = request;
  asked.sample_rate = request.sample_rate.value_or(output->default_rate);
  if (auto status = fits(asked, *input, *output); !status) return tl::unexpected(status.error());
  if (input->api != output->api)
    return fail(Errc::BadArgument, "",
                "'" + input->id + "' and '" + output->id + "' cannot be opened together",
                "choose two devices of the same API, or use JACK");
  DeviceChoice choice{*input, *output, {}};
  choice.granted.device = output->id;
  // What is no card's own device in ALSA is a plugin: for a mixer, or for a sound server.
  choice.granted.writers_unknown =
      output->api == "jack" || output->api == "pulse" ||
      (output->api == "alsa" && output->library_name.find("hw:") == std::string::npos);
  if (input->id != output->id) choice.granted.input_device = input->id;
  choice.granted.format = {*asked.sample_rate, request.in_channels, request.out_channels, 0};
  if (request.in_channels > 0)
    choice.granted.input = {input->hardware, input->in_channels, {}, input->ambiguous};
  if (request.out_channels > 0)
    choice.granted.output = {output->hardware, output->out_channels, {}, output->ambiguous};
  return choice;
}

void distinguish_same_ids(std::vector<Device>& devices) {
  std::map<std::string, int> names, places;
  for (const auto& device : devices) {
    ++names[device.id];
    ++places[with_hardware(device.id, device.hardware)];
  }
  std::map<std::string, int> seen;
  for (auto& device : devices) {
    if (names[device.id] == 1) continue;
    const int number = ++seen[device.id];
    if (!device.hardware.empty() && places[with_hardware(device.id, device.hardware)] == 1) {
      device.id = with_hardware(device.id, device.hardware);
      continue;
    }
    device.ambiguous = true;
    if (number > 1) device.id += " #" + std::to_string(number);
  }
}

static bool doubtful(const DeviceIdentity& before, const DeviceIdentity& now) {
  return before.may_be_another() || now.may_be_another();
}

static void add_doubt(bool doubtful, const char* what, std::vector<std::string>& found) {
  if (doubtful) found.push_back(fmt::format("it may be another device of the same name: check its {}", what));
}

/// `of`: the device, where it is not the first one: " of the second device".
static void compare(const DeviceIdentity& before, const DeviceIdentity& now, const char* what,
                    std::vector<std::string>& found, const char* of = "") {
  if (before.hardware != now.hardware)
    found.push_back(fmt::format("the hardware of the {}s{} is '{}' instead of '{}'", what, of, now.hardware,
                                before.hardware));
  if (before.channels != now.channels)
    found.push_back(fmt::format("it has {} {}s{} instead of {}", now.channels, what, of, before.channels));
  for (std::size_t c = 0; c < std::min(before.ports.size(), now.ports.size()); ++c)
    if (before.ports[c] != now.ports[c])
      found.push_back(
          fmt::format("{} {}{} is '{}' instead of '{}'", what, c + 1, of, now.ports[c], before.ports[c]));
}

static void compare_names(const StreamGranted& before, const StreamGranted& now,
                          std::vector<std::string>& found) {
  // On the same hardware only the name changed: another device of the same name came or went.
  if (before.device != now.device && (now.output.hardware.empty() || before.output != now.output))
    found.push_back(fmt::format("it is '{}' instead of '{}'", now.device, before.device));
}

static void compare_settings(const StreamGranted& before, const StreamGranted& now,
                             std::vector<std::string>& found) {
  const auto differs = [&](const char* what, double was, double is, const char* unit) {
    if (was != is) found.push_back(fmt::format("{} is now {:g}{} instead of {:g}", what, is, unit, was));
  };
  differs("the sample rate", before.format.sample_rate.value, now.format.sample_rate.value, " Hz");
  differs("the block size", before.block_frames, now.block_frames, " frames");
  differs("the number of periods", before.periods, now.periods, "");
}

static void compare_second(const StreamGranted& before, const StreamGranted& now, bool doubt,
                           std::vector<std::string>& found) {
  if (!before.second || !now.second) return;
  const auto &one = *before.second, &other = *now.second;
  constexpr const char* kOf = " of the second device";
  add_doubt(doubt && (doubtful(one.input, other.input) || doubtful(one.output, other.output)),
            "second device", found);
  compare(one.input, other.input, "input", found, kOf);
  compare(one.output, other.output, "output", found, kOf);
}

std::vector<std::string> differences(const StreamGranted& before, const StreamGranted& now) {
  std::vector<std::string> found;
  compare_names(before, now, found);
  add_doubt(doubtful(before.input, now.input), "inputs", found);
  compare(before.input, now.input, "input", found);
  add_doubt(doubtful(before.output, now.output), "outputs", found);
  compare(before.output, now.output, "output", found);
  compare_second(before, now, true, found);
  if (before.renames != now.renames) found.push_back("its ports were renamed");
  compare_settings(before, now, found);
  return found;
}

std::vector<std::string> differences_between_openings(const StreamGranted& before, const StreamGranted& now,
                                                      bool same_settings) {
  std::vector<std::string> found;
  if (before.connection != now.connection) found.push_back("it left its server and came back");
  compare_names(before, now, found);
  compare(before.input, now.input, "input", found);
  compare(before.output, now.output, "output", found);
  compare_second(before, now, false, found);
  if (same_settings) compare_settings(before, now, found);
  return found;
}

}  // namespace tactus
