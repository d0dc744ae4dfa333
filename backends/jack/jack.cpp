#include <fmt/format.h>
#include <jack/jack.h>

#include <algorithm>
#include <utility>

#include "backends/card_stream.h"
#include "backends/find_device.h"
#include "backends/jack/client.h"
#include "engine/core/index.h"

namespace tactus {
namespace {

using jack::ask_server;
using jack::Client;
using jack::Wire;
using Names = std::vector<std::string>;

/// A client of the server with audio ports, by their full names, in the server's order.
struct Card {
  std::string client;
  Names captures;   ///< that sound comes out of
  Names playbacks;  ///< that sound goes into
};

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

/// All clients with audio ports, those with real hardware behind them first.
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

/// The same as devices; the first one is the default.
std::vector<Device> devices_of(const Client& client, const std::vector<Card>& cards) {
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

class JackStream final : public CardStream {
 public:
  JackStream(std::shared_ptr<Client> client, StreamGranted granted)
      : CardStream(std::move(granted)), client_(std::move(client)) {
    reported_block_ = this->granted().block_frames;
  }

  ~JackStream() override {
    (void)stop();
    client_->callback().abandon();
  }

  std::string take_note() override {
    if (const int block = client_->block_frames(); block != reported_block_)
      return fmt::format("the JACK block size is now {} frames instead of {}: the delay has changed", block,
                         std::exchange(reported_block_, block));
    if (!running() || client_->lost()) return {};
    const int rewirings = client_->rewirings();
    if (rewirings == reported_rewirings_) return {};
    const auto now = client_->connected();
    const auto& wires = client_->wires();
    for (std::size_t w = 0; w < wires.size(); ++w)
      if (now[w] != connected_[w]) {
        connected_[w] = now[w];
        return fmt::format("another program {} '{}' and '{}'", now[w] ? "connected" : "disconnected",
                           wires[w].from, wires[w].to);
      }
    reported_rewirings_ = rewirings;
    return {};
  }

 private:
  CardCallback& card() const override { return client_->callback(); }
  bool lost() const override { return client_->lost(); }
  Status start_library() override {
    auto started = ask_server([client = client_] { return client->activate(); });
    if (!started) (void)deactivate();
    reported_rewirings_ = client_->rewirings();
    connected_.assign(client_->wires().size(), true);
    return started;
  }
  Status stop_library(bool finished) override {
    if (lost())
      return fail(Errc::Device, "", "the JACK server or the device was disconnected",
                  "reopen the stream when they are available again");
    if (auto status = deactivate(); !status) return status;
    return finished ? Status{} : jack::no_answer();
  }
  Status deactivate() {
    return ask_server([client = client_] { return client->deactivate(), Status{}; });
  }

  std::shared_ptr<Client> client_;
  std::vector<bool> connected_;  ///< as last reported
  int reported_block_ = 0, reported_rewirings_ = 0;
};

std::vector<Wire> wires(const Client& client, const StreamRequest& request, const Card& input,
                        const Card& output) {
  const auto port = [](const std::vector<std::string>& ports, const std::vector<int>& map, int channel) {
    const auto c = index(channel);
    return ports[map.empty() ? c : index(map[c])];
  };
  std::vector<Wire> wires;
  for (int c = 0; c < request.in_channels; ++c)
    wires.push_back({port(input.captures, request.in_map, c), client.input_port(c)});
  for (int c = 0; c < request.out_channels; ++c)
    wires.push_back({client.output_port(c), port(output.playbacks, request.out_map, c)});
  return wires;
}

/// Our ports are the channels themselves: what is mapped are the wires.
StreamRequest unmapped(StreamRequest request) {
  request.in_map = request.out_map = {};
  return request;
}

/// The running JACK server, or PipeWire in its place: the default one, or that of $JACK_DEFAULT_SERVER. Every
/// client that has audio ports is a device: "jack:system" is the sound card. The server decides rate and
/// block size for all: another rate is refused, another block is not granted. This never starts a server.
///
/// A stream is Lost when the server or the device's ports go away, and Stalled while the server does not
/// answer. Changes that others make to its connections are kept, and reported by `take_note`. A call that
/// the server does not answer within two seconds is an error; what hangs is left to itself, silent.
class JackBackend final : public Backend {
 public:
  std::string name() const override { return "jack"; }
  Result<std::vector<Device>> devices() override {
    return ask_server([]() -> Result<std::vector<Device>> {
      const auto client = Client::open("tactus-devices");
      if (!client) return tl::unexpected(client.error());
      return devices_of(**client, cards(**client));
    });
  }
  Result<std::unique_ptr<Stream>> open(const StreamRequest& request, Guarded& processor) override {
    const auto opened = ask_server([name = request.client_name] { return Client::open(name); });
    if (!opened) return tl::unexpected(opened.error());
    const auto& client = *opened;
    const auto found = cards(*client);
    const auto devices = devices_of(*client, found);
    const auto choice = choose(devices, request);
    if (!choice) return tl::unexpected(choice.error());
    const auto add_ports = [client, in = request.in_channels, out = request.out_channels] {
      return client->add_ports(in, out);
    };
    if (auto status = ask_server(add_ports); !status) return tl::unexpected(status.error());
    auto granted = choice->granted;
    // A longer block, when the server changes to one, is cut.
    granted.format.max_frames = granted.block_frames = client->block_frames();
    if (request.in_channels > 0) granted.input_latency_frames = devices[choice->input].input_latency_frames;
    if (request.out_channels > 0)
      granted.output_latency_frames = devices[choice->output].output_latency_frames;
    if (auto status = processor.prepare(granted.format); !status) return tl::unexpected(status.error());
    client->play_through(std::make_unique<CardCallback>(processor, unmapped(request), granted, true),
                         wires(*client, request, found[choice->input], found[choice->output]));
    return std::make_unique<JackStream>(client, std::move(granted));
  }
};

}  // namespace

std::unique_ptr<Backend> make_jack_backend() { return std::make_unique<JackBackend>(); }

}  // namespace tactus
