#include "backends/jack/jack.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "backends/find_device.h"
#include "backends/jack/client.h"
#include "backends/jack/jack_cards.h"
#include "engine/core/index.h"

namespace tactus {
namespace {

using jack::call_with_timeout;
using jack::Client;
using jack::Wire;

Status gone() {
  return fail(Errc::Device, "", "the JACK server or the device has gone away",
              "destroy the stream and open it again when they are back");
}

class JackStream final : public Stream {
 public:
  JackStream(std::shared_ptr<Client> client, StreamGranted granted, std::vector<Wire> wires)
      : client_(std::move(client)), granted_(std::move(granted)), wires_(std::move(wires)) {
    told_block_ = granted_.block_frames;
  }

  ~JackStream() override {
    (void)stop();
    client_->callback().abandon();
  }

  const StreamGranted& granted() const override { return granted_; }

  Status start() override {
    if (running_) return {};
    if (client_->lost()) return gone();
    auto started = call_with_timeout<void>([client = client_] { return client->activate(); });
    if (!started) {
      (void)deactivate();
      return started;
    }
    told_rewirings_ = client_->rewirings();
    connected_.assign(wires_.size(), true);
    client_->callback().play();
    running_ = true;
    return {};
  }

  Status stop() override {
    if (!std::exchange(running_, false)) return {};
    const bool finished = !client_->lost() && client_->callback().finish();
    client_->callback().abandon();
    if (client_->lost()) return gone();
    if (auto status = deactivate(); !status) return status;
    return finished ? Status{} : jack::no_answer();
  }

  StreamState state() const override {
    if (client_->lost()) return StreamState::Lost;
    if (!running_) return StreamState::Stopped;
    return client_->callback().stalled() ? StreamState::Stalled : StreamState::Running;
  }
  Health health() const override { return client_->callback().health(); }

  std::string take_note() override {
    if (const int block = client_->block_frames(); block != told_block_)
      return fmt::format("JACK's blocks have {} frames now and had {}: the delay has changed", block,
                         std::exchange(told_block_, block));
    if (!running_ || client_->lost()) return {};
    const int rewirings = client_->rewirings();
    if (rewirings == told_rewirings_) return {};
    const auto now = client_->connected();
    for (std::size_t w = 0; w < wires_.size(); ++w)
      if (now[w] != connected_[w]) {
        connected_[w] = now[w];
        return fmt::format("somebody {} '{}' and '{}'", now[w] ? "connected" : "disconnected", wires_[w].from,
                           wires_[w].to);
      }
    told_rewirings_ = rewirings;
    return {};
  }

 private:
  Status deactivate() {
    return call_with_timeout<void>([client = client_]() -> Status { return client->deactivate(), Status{}; });
  }

  std::shared_ptr<Client> client_;
  StreamGranted granted_;
  std::vector<Wire> wires_;
  std::vector<bool> connected_;  ///< as last reported
  int told_block_ = 0, told_rewirings_ = 0;
  bool running_ = false;
};

const jack::Card& card_of(const std::vector<jack::Card>& cards, const std::vector<Device>& devices,
                          const Device& device) {
  const auto same = [&](const Device& other) { return other.id == device.id; };
  return cards[index(std::find_if(devices.begin(), devices.end(), same) - devices.begin())];
}

std::vector<Wire> wires(const Client& client, const StreamRequest& request, const jack::Card& input,
                        const jack::Card& output) {
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

StreamGranted granted(const StreamRequest& request, const DeviceChoice& choice, const Client& client) {
  auto granted = granted_for(choice, request);
  // A longer block, when the server changes to one, is cut.
  granted.format.max_frames = granted.block_frames = client.block_frames();
  if (request.in_channels > 0) granted.input_latency_frames = choice.input.input_latency_frames;
  if (request.out_channels > 0) granted.output_latency_frames = choice.output.output_latency_frames;
  return granted;
}

/// Our ports are the channels themselves: what is mapped are the wires.
StreamRequest unmapped(StreamRequest request) {
  request.in_map = request.out_map = {};
  return request;
}

}  // namespace

Result<std::vector<Device>> JackBackend::devices() {
  return call_with_timeout<std::vector<Device>>([]() -> Result<std::vector<Device>> {
    const auto client = Client::open("tactus-devices");
    if (!client) return tl::unexpected(client.error());
    return jack::devices(**client, jack::cards(**client));
  });
}

Result<std::unique_ptr<Stream>> JackBackend::open(const StreamRequest& request, Guarded& processor) {
  using Opened = std::shared_ptr<Client>;
  const auto client = call_with_timeout<Opened>([name = request.client_name] { return Client::open(name); });
  if (!client) return tl::unexpected(client.error());
  const auto cards = jack::cards(**client);
  const auto devices = jack::devices(**client, cards);
  const auto choice = choose(devices, request);
  if (!choice) return tl::unexpected(choice.error());
  const auto add_ports = [client = *client, in = request.in_channels, out = request.out_channels] {
    return client->add_ports(in, out);
  };
  if (auto status = call_with_timeout<void>(add_ports); !status) return tl::unexpected(status.error());
  auto grant = granted(request, *choice, **client);
  if (auto status = processor.prepare(grant.format); !status) return tl::unexpected(status.error());
  auto to_connect = wires(**client, request, card_of(cards, devices, choice->input),
                          card_of(cards, devices, choice->output));
  (*client)->play_through(std::make_unique<CardCallback>(processor, unmapped(request), grant, true),
                          to_connect);
  return std::make_unique<JackStream>(*client, std::move(grant), std::move(to_connect));
}

std::unique_ptr<Backend> make_jack_backend() { return std::make_unique<JackBackend>(); }

}  // namespace tactus
