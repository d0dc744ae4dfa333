#include "backends/rtaudio/rtaudio_devices.h"

#include <RtAudio.h>

#include <algorithm>
#include <exception>
#include <memory>

#include "backends/call_with_timeout.h"

namespace tactus {
namespace {

RtAudioDevice described(const std::string& api, unsigned index, const RtAudio::DeviceInfo& info) {
  RtAudioDevice found{{}, api, info.name, index};
  auto& device = found.device;
  device.id = "rtaudio:" + api + ":" + info.name;
  device.name = info.name + " (" + RtAudio::getApiDisplayName(RtAudio::getCompiledApiByName(api)) + ")";
  device.in_channels = static_cast<int>(info.inputChannels);
  device.out_channels = static_cast<int>(info.outputChannels);
  for (const auto rate : info.sampleRates) device.sample_rates.push_back(Hertz{static_cast<double>(rate)});
  device.default_rate = Hertz{static_cast<double>(info.preferredSampleRate)};
  device.is_default = info.isDefaultOutput;
  return found;
}

std::vector<RtAudioDevice> probe(RtAudio::Api api) {
  std::vector<RtAudioDevice> found;
  try {
    RtAudio library{api};
    library.showWarnings(false);
    for (unsigned i = 0, count = library.getDeviceCount(); i < count; ++i) {
      const auto info = library.getDeviceInfo(i);
      if (info.probed && info.inputChannels + info.outputChannels > 0 && !info.sampleRates.empty())
        found.push_back(described(RtAudio::getApiName(api), i, info));
    }
  } catch (const std::exception&) {  // a device went away while it was asked: those before it are there
  }
  return found;
}

/// RtAudio takes a JACK client's name for a pattern, so that it counts, and would open, the ports of "a_b"
/// with those of "b". A client whose ports come before those of all that it is taken for keeps its own; any
/// other cannot be opened. A client whose ports do not lie together is there twice.
std::vector<RtAudioDevice> own_ports_only(std::vector<RtAudioDevice> devices) {
  std::stable_sort(devices.begin(), devices.end(), [](const RtAudioDevice& a, const RtAudioDevice& b) {
    return a.name.size() > b.name.size();
  });
  std::vector<RtAudioDevice> usable;
  for (auto one = devices.begin(); one != devices.end(); ++one) {
    bool first = true;
    for (auto other = devices.begin(); other != one; ++other) {
      if (other->name.find(one->name) == std::string::npos) continue;
      first = first && one->index < other->index;
      if (other->name == one->name) continue;
      one->device.in_channels -= other->device.in_channels;
      one->device.out_channels -= other->device.out_channels;
    }
    if (first) usable.push_back(*one);
  }
  std::sort(usable.begin(), usable.end(),
            [](const RtAudioDevice& a, const RtAudioDevice& b) { return a.index < b.index; });
  return usable;
}

void tell_apart(std::vector<RtAudioDevice>& devices) {
  for (auto one = devices.begin(); one != devices.end(); ++one) {
    const auto same = std::count_if(devices.begin(), one, [&](const RtAudioDevice& other) {
      return other.api == one->api && other.name == one->name;
    });
    if (same > 0) one->device.id += " #" + std::to_string(same + 1);
  }
}

/// The outputs' default of the first API that has one, or else the first device with inputs.
void one_default(std::vector<RtAudioDevice>& devices) {
  auto chosen = std::find_if(devices.begin(), devices.end(),
                             [](const RtAudioDevice& found) { return found.device.is_default; });
  if (chosen == devices.end()) chosen = devices.begin();
  for (auto one = devices.begin(); one != devices.end(); ++one) one->device.is_default = one == chosen;
}

}  // namespace

Result<std::vector<RtAudioDevice>> rtaudio_devices(const std::string& text) {
  std::vector<RtAudio::Api> apis;
  RtAudio::getCompiledApi(apis);
  const auto named = std::find_if(apis.begin(), apis.end(), [&](RtAudio::Api api) {
    return text.starts_with("rtaudio:" + RtAudio::getApiName(api) + ":");
  });
  if (named != apis.end()) apis = {*named};
  std::vector<RtAudioDevice> devices;
  std::string silent;
  for (const auto api : apis) {
    const auto found = std::make_shared<std::vector<RtAudioDevice>>();
    if (!call_with_timeout([api, found] { *found = probe(api); })) {
      silent = RtAudio::getApiDisplayName(api);
      continue;
    }
    const auto usable = api == RtAudio::UNIX_JACK ? own_ports_only(*found) : *found;
    devices.insert(devices.end(), usable.begin(), usable.end());
  }
  if (devices.empty() && !silent.empty())
    return fail(Errc::Device, "", silent + " does not answer", "restart its server");
  tell_apart(devices);
  one_default(devices);
  return devices;
}

}  // namespace tactus
