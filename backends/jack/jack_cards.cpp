#include "backends/jack/jack_cards.h"

#include <jack/jack.h>

#include <algorithm>
#include <optional>

namespace tactus::jack {
namespace {

using Names = std::vector<std::string>;

/// `flags` as JACK sees them: sound comes out of an output port.
Names ports(const Client& client, unsigned long flags) {
  Names names;
  const char** found = jack_get_ports(client.handle(), nullptr, JACK_DEFAULT_AUDIO_TYPE, flags);
  for (const char** port = found; port != nullptr && *port != nullptr; ++port) names.emplace_back(*port);
  jack_free(found);
  return names;
}

std::string client_of(const std::string& port) { return port.substr(0, port.find(':')); }

/// The largest delay between these ports and the world outside [frames].
std::optional<double> latency(const Client& client, const Names& names, jack_latency_callback_mode_t mode) {
  std::optional<double> most;
  for (const auto& name : names) {
    auto* port = jack_port_by_name(client.handle(), name.c_str());
    if (port == nullptr) continue;
    jack_latency_range_t range{};
    jack_port_get_latency_range(port, mode, &range);
    most = std::max(most.value_or(0.0), static_cast<double>(range.max));
  }
  return most;
}

}  // namespace

std::vector<Card> cards(const Client& client) {
  std::vector<Card> found;
  const auto card = [&](const std::string& port) -> Card& {
    const auto name = client_of(port);
    const auto same = [&](const Card& c) { return c.client == name; };
    const auto known = std::find_if(found.begin(), found.end(), same);
    return known != found.end() ? *known : found.emplace_back(Card{name, {}, {}});
  };
  for (const auto& port : ports(client, JackPortIsPhysical)) card(port);
  for (const auto& port : ports(client, JackPortIsOutput)) card(port).captures.push_back(port);
  for (const auto& port : ports(client, JackPortIsInput)) card(port).playbacks.push_back(port);
  return found;
}

std::vector<Device> devices(const Client& client, const std::vector<Card>& cards) {
  std::vector<Device> devices;
  for (const auto& card : cards) {
    Device device;
    device.id = "jack:" + card.client;
    device.name =
        card.client == "system" ? "the sound card of the JACK server" : "JACK client " + card.client;
    device.in_channels = static_cast<int>(card.captures.size());
    device.out_channels = static_cast<int>(card.playbacks.size());
    device.default_rate = Hertz{client.sample_rate()};
    device.sample_rates = {device.default_rate};
    device.block_frames = client.block_frames();
    device.input_latency_frames = latency(client, card.captures, JackCaptureLatency);
    device.output_latency_frames = latency(client, card.playbacks, JackPlaybackLatency);
    device.is_default = devices.empty();
    devices.push_back(std::move(device));
  }
  return devices;
}

}  // namespace tactus::jack
