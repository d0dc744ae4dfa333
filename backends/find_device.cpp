#include "backends/find_device.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <set>

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

Status fits(int channels, const std::vector<int>& map, int available, const char* what,
            const std::string& device) {
  const auto at = "'" + device + "'";
  if (channels < 0)
    return fail(Errc::BadArgument, "", fmt::format("there cannot be {} {}", channels, what), "");
  if (!map.empty() && map.size() != index(channels))
    return fail(Errc::BadArgument, "",
                fmt::format("{} {} of the device are chosen, but {} are needed", map.size(), what, channels),
                "choose one for each");
  const int last = channels_to_open(channels, map);
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
  if (!(std::isfinite(rate) && rate >= 8e3 && rate <= 192e3))
    return fail(Errc::OutOfRange, "", fmt::format("{} Hz is not a sample rate of sound cards", rate),
                "choose 8 kHz to 192 kHz");
  const auto& rates = device.sample_rates;
  if (rates.empty() || std::count(rates.begin(), rates.end(), *request.sample_rate) > 0) return {};
  std::string text;
  for (const auto& supported : rates)
    text += fmt::format("{}{:g}", text.empty() ? "" : ", ", supported.value);
  return fail(Errc::BadArgument, "", fmt::format("'{}' does not run at {:g} Hz", device.id, rate),
              "it runs at " + text + " Hz; omit the rate, or set the device to another rate");
}

Status fits(const StreamRequest& request, const Device& input, const Device& output) {
  if (auto status = fits(request.in_channels, request.in_map, input.in_channels, "inputs", input.id); !status)
    return status;
  if (auto status = fits(request.out_channels, request.out_map, output.out_channels, "outputs", output.id);
      !status)
    return status;
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

int channels_to_open(int channels, const std::vector<int>& map) {
  return map.empty() ? channels : *std::max_element(map.begin(), map.end()) + 1;
}

Result<Device> device_with_id(const std::vector<Device>& devices, const std::string& id) {
  const auto remedy =
      devices.empty()
          ? std::
                string{"no device was found; check that it is connected and that the sound server is running"}
          : "there is " + listed(devices);
  const auto chosen = [&](const Device& device) { return id.empty() ? device.is_default : device.id == id; };
  if (const auto found = std::find_if(devices.begin(), devices.end(), chosen); found != devices.end())
    return *found;
  return fail(Errc::UnknownName, "",
              id.empty() ? "there is no default device" : "there is no device '" + id + "'", remedy);
}

Result<Device> find_device(const std::vector<Device>& devices, const std::string& text) {
  auto exact = device_with_id(devices, text);
  if (exact || text.empty()) return exact;
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
  auto output = device_with_id(devices, request.out_channels == 0 ? at_input : request.device);
  auto input = request.in_channels == 0 ? output : device_with_id(devices, at_input);
  if (!output) return tl::unexpected(output.error());
  if (!input) return tl::unexpected(input.error());
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
  if (input->id != output->id) choice.granted.input_device = input->id;
  choice.granted.format = {*asked.sample_rate, request.in_channels, request.out_channels, 0};
  return choice;
}

void number_same_ids(std::vector<Device>& devices) {
  for (auto one = devices.end(); one != devices.begin();) {
    --one;
    const auto before =
        std::count_if(devices.begin(), one, [&](const Device& other) { return other.id == one->id; });
    if (before > 0) one->id += " #" + std::to_string(before + 1);
  }
}

}  // namespace tactus
