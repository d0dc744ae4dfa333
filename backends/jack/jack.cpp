#include <fmt/format.h>
#include <jack/jack.h>

#include <algorithm>
#include <atomic>
#include <utility>

#include "backends/alsa_devices.h"
#include "backends/find_device.h"
#include "backends/jack/client.h"
#include "backends/jack/midi_inputs.h"
#include "engine/core/index.h"

namespace tactus {
namespace {

using jack::ask_server;
using jack::Client;
using jack::Names;
using jack::Wire;

/// A client of the server with audio ports, by their full names, in the server's order.
struct Card {
  std::string client;
  Names captures;   ///< that sound comes out of
  Names playbacks;  ///< that sound goes into
};

/// `flags` as JACK sees them: sound comes out of an output port.
Names ports(const Client& client, unsigned long flags) {
  return jack::names_of(jack_get_ports(client.handle, nullptr, JACK_DEFAULT_AUDIO_TYPE, flags));
}

/// The largest delay between these ports and the world outside [frames].
std::optional<double> latency(const Client& client, const Names& names, jack_latency_callback_mode_t mode) {
  std::optional<double> most;
  for (const auto& name : names) {
    auto* port = jack_port_by_name(client.handle, name.c_str());
    if (port == nullptr) continue;
    jack_latency_range_t range{};
    jack_port_get_latency_range(port, mode, &range);
    most = std::max(most.value_or(0.0), static_cast<double>(range.max));
  }
  return most;
}

/// The aliases of a port, in which its driver names the hardware.
Names aliases_of(const Client& client, const std::string& name) {
  const auto size = static_cast<std::size_t>(jack_port_name_size());
  std::string first(size, '\0'), second(size, '\0');
  char* aliases[] = {first.data(), second.data()};
  const auto* port = jack_port_by_name(client.handle, name.c_str());
  const int count = port == nullptr ? 0 : jack_port_get_aliases(port, aliases);
  return {aliases, aliases + std::max(count, 0)};
}

/// The hardware that an alias means, and no other, for as long as it is connected there: an ALSA card with
/// its place ("alsa_pcm:hw:1:out1@1-2:1.0"), or a driver of the server that has no hardware. Empty: unknown,
/// as for "alsa_pcm:default:out1".
std::string hardware_of(const std::string& alias) {
  if (alias.starts_with("dummy_pcm:") || alias.starts_with("loopback:")) return alias;
  const auto place = alsa_hardware_named(alias);
  return place.empty() ? "" : alias + "@" + place;
}

/// That of each port in turn. Empty: that of a port is unknown.
std::string hardware_of(const Client& client, const Names& ports) {
  std::string all;
  for (const auto& port : ports) {
    std::string one;
    for (const auto& alias : aliases_of(client, port))
      if (const auto hardware = hardware_of(alias); !hardware.empty()) one += " " + hardware;
    if (one.empty()) return {};
    all += one;
  }
  return all;
}

/// All clients with audio ports, those with real hardware behind them first.
std::vector<Card> cards(const Client& client) {
  std::vector<Card> found;
  const auto card = [&](const std::string& port) -> Card& {
    const auto name = jack::client_of(port);
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
    device.default_rate = Hertz{static_cast<double>(jack_get_sample_rate(client.handle))};
    device.sample_rates = {device.default_rate};
    device.block_frames = client.block_frames;
    device.input_latency_frames = latency(client, card.captures, JackCaptureLatency);
    device.output_latency_frames = latency(client, card.playbacks, JackPlaybackLatency);
    device.is_default = devices.empty();
    device.index = static_cast<int>(devices.size());
    devices.push_back(std::move(device));
  }
  return devices;
}

/// The ids that the server gave the clients that these ports are of: a client that leaves and comes back has
/// another one.
Result<std::string> connection_of(Client& client, const StreamGranted& granted) {
  std::string ids;
  for (const auto* ports : {&granted.input.ports, &granted.output.ports})
    if (!ports->empty()) ids += (ids.empty() ? "" : " ") + client.id_of(jack::client_of(ports->front()));
  return ids;
}

class JackStream final : public CardStream<Client> {
 public:
  JackStream(std::shared_ptr<Client> client, StreamGranted granted, const StreamRequest& request,
             GuardedBlocks& processor, std::shared_ptr<jack::PlayingClient> playing)
      : CardStream(std::move(client), std::move(granted), request, processor), playing_(std::move(playing)) {}
  ~JackStream() override {
    (void)stop();
    line_->card->abandon();
  }

  int block_frames() const override { return line_->block_frames; }

  std::vector<OtherWriter> other_writers() const override {
    if (line_->lost) return {};
    if (const int rewirings = line_->rewirings; !running() || rewirings != writers_as_of_) {
      writers_ = line_->other_writers();
      writers_as_of_ = running() ? rewirings : -1;
      for (auto& writer : line_->take_passing_writers())
        if (std::ranges::find(writers_, writer) == writers_.end()) {
          writers_.push_back(std::move(writer));
          writers_as_of_ = -1;  // it is gone at the next look
        }
    }
    return writers_;
  }

  bool take_output_cut() override {
    // A device that goes away disconnects first: none that is still there at the next call does.
    const int cuts = line_->output_cuts;
    const bool is_going = std::exchange(seen_output_cuts_, cuts) != cuts;
    return !is_going && !line_->lost && std::exchange(reported_output_cuts_, cuts) != cuts;
  }

  std::string take_note() override {
    if (const int rate = line_->new_rate; rate != 0 && !std::exchange(reported_rate_, true))
      return fmt::format("the sample rate is now {} Hz instead of {}", rate, line_->sample_rate);
    if (!running() || line_->lost) return {};
    if (is_left_out()) {
      line_->lost = true;
      return "the server runs, but without this program";
    }
    const int rewirings = line_->rewirings;
    if (rewirings == reported_rewirings_) return {};
    const auto now = line_->connected();
    const auto& wires = line_->wires;
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
  bool lost() const override { return line_->lost; }
  Status start_library() override {
    auto started = ask_server([client = line_, before = granted()]() -> Status {
      if (auto status = client->activate(); !status) return status;
      // The wires were connected by names. From now on the stream is lost when a client leaves.
      if (*connection_of(*client, before) == before.connection) return {};
      return fail(Errc::Device, "", "'" + before.device + "' left the JACK server while it was opened",
                  "open it again");
    });
    if (!started) (void)deactivate();
    playing_->set(started ? line_ : nullptr);
    reported_rewirings_ = line_->rewirings;
    seen_output_cuts_ = reported_output_cuts_ = line_->output_cuts;
    connected_.assign(line_->wires.size(), true);
    return started;
  }
  Status stop_library(bool finished) override {
    playing_->set(nullptr);
    if (lost())
      return fail(Errc::Device, "", "the JACK server or the device was disconnected",
                  "reopen the stream when they are available again");
    if (auto status = deactivate(); !status) return status;
    return finished ? Status{} : jack::no_answer();
  }
  /// The server's cycles go on, and none of them is ours: JACK may lose a client whose connections form a
  /// loop.
  bool is_left_out() {
    const auto cycle = jack_last_frame_time(line_->handle);
    const bool begins = cycle != std::exchange(last_cycle_, cycle);
    cycles_left_out_ = line_->card->stalled() ? cycles_left_out_ + (begins ? 1 : 0) : 0;
    return cycles_left_out_ > kCyclesLeftOut;
  }
  Status deactivate() {
    return ask_server([client = line_] { return client->deactivate(), Status{}; });
  }

  static constexpr int kCyclesLeftOut = 10;

  const std::shared_ptr<jack::PlayingClient> playing_;
  jack_nframes_t last_cycle_ = 0;
  int cycles_left_out_ = 0;      ///< seen while it is stalled
  std::vector<bool> connected_;  ///< as last reported
  int reported_rewirings_ = 0;
  int seen_output_cuts_ = 0, reported_output_cuts_ = 0;
  bool reported_rate_ = false;
  mutable std::vector<OtherWriter> writers_;
  mutable int writers_as_of_ = -1;  ///< Client::rewirings
};

/// The ports of a device behind these channels. Those of a device that returns are found by their names:
/// another order is nothing to those who play on it. Errors: Device for a name that is missing.
Result<Names> ports_behind(const Names& there, const std::vector<int>& channels, const Names& before) {
  for (const auto& name : before)
    if (std::find(there.begin(), there.end(), name) == there.end())
      return fail(Errc::Device, "", "JACK has no port '" + name + "'", "check with jack_lsp");
  if (!before.empty()) return before;
  Names names;
  for (const int channel : channels) names.push_back(there[index(channel)]);
  return names;
}

/// The ports of both devices, into what is granted.
Status choose_ports(const Client& client, const StreamRequest& request, const Card& input, const Card& output,
                    StreamGranted& granted) {
  const auto before = request.previous.value_or(StreamGranted{});
  auto from =
      ports_behind(input.captures, channels_of(request.in_map, request.in_channels), before.input.ports);
  auto to =
      ports_behind(output.playbacks, channels_of(request.out_map, request.out_channels), before.output.ports);
  if (!from) return tl::unexpected(from.error());
  if (!to) return tl::unexpected(to.error());
  granted.input.hardware = hardware_of(client, *from);
  granted.output.hardware = hardware_of(client, *to);
  granted.input.ports = std::move(*from);
  granted.output.ports = std::move(*to);
  return {};
}

std::vector<Wire> wires(const Client& client, const StreamGranted& granted) {
  std::vector<Wire> wires;
  for (int c = 0; const auto& from : granted.input.ports) wires.push_back({from, client.input_port(c++)});
  for (int c = 0; const auto& to : granted.output.ports) wires.push_back({client.output_port(c++), to});
  return wires;
}

/// The running JACK server, or PipeWire in its place: the default one, or that of $JACK_DEFAULT_SERVER. Every
/// client that has audio ports is a device: "jack:system" is the sound card. The server decides rate and
/// block size for all: another rate is refused, another block is not granted. This never starts a server.
///
/// A stream is Lost when the server or the device's ports go away or get other names and when the server
/// changes its rate, and Stalled while the server does not answer. While the server freewheels, zeros go out
/// and the processor is left alone. A device that returns is connected to the same ports by their names.
/// Changes that others make to its connections are kept, and reported by `take_note`. A call that the server
/// does not answer within two seconds is an error; what hangs is left to itself, silent.
class JackBackend final : public Backend {
 public:
  std::string name() const override { return "jack"; }
  Result<std::vector<Device>> devices() override {
    return ask_server([] {
      return Client::open("tactus-devices").map([](const auto& client) {
        return devices_of(*client, cards(*client));
      });
    });
  }
  Result<std::unique_ptr<Stream>> open(const StreamRequest& request, GuardedBlocks& processor) override {
    const auto opened = ask_server([name = request.client_name] { return Client::open(name); });
    if (!opened) return tl::unexpected(opened.error());
    const auto& client = *opened;
    const auto found = cards(*client);
    const auto choice = choose(devices_of(*client, found), request);
    if (!choice) return tl::unexpected(choice.error());
    const auto add_ports = [client, in = request.in_channels, out = request.out_channels] {
      return client->add_ports(in, out);
    };
    if (auto status = ask_server(add_ports); !status) return tl::unexpected(status.error());
    auto granted = choice->granted;
    // A longer block, when the server changes to one, is cut.
    granted.format.max_frames = granted.block_frames = client->block_frames;
    if (request.in_channels > 0) granted.input_latency_frames = choice->input.input_latency_frames;
    if (request.out_channels > 0) granted.output_latency_frames = choice->output.output_latency_frames;
    if (auto status = choose_ports(*client, request, found[index(choice->input.index)],
                                   found[index(choice->output.index)], granted);
        !status)
      return tl::unexpected(status.error());
    auto connection = ask_server([client, granted] { return connection_of(*client, granted); });
    if (!connection) return tl::unexpected(connection.error());
    granted.connection = std::move(*connection);
    granted.renames = *renames_;
    client->renames = renames_;
    client->wires = wires(*client, granted);
    if (auto status = processor.prepare(granted.format); !status) return tl::unexpected(status.error());
    auto unmapped = request;  // our ports are the channels themselves: what is mapped are the wires
    unmapped.in_map = unmapped.out_map = {};
    return std::make_unique<JackStream>(client, std::move(granted), unmapped, processor, playing_);
  }
  std::shared_ptr<MidiInputs> midi_inputs(std::chrono::milliseconds interval) override {
    return jack::make_midi_inputs(playing_, interval);
  }

 private:
  const std::shared_ptr<jack::PlayingClient> playing_ = std::make_shared<jack::PlayingClient>();
  const std::shared_ptr<std::atomic<int>> renames_ = std::make_shared<std::atomic<int>>(0);
};

}  // namespace

std::unique_ptr<Backend> make_jack_backend() { return std::make_unique<JackBackend>(); }

}  // namespace tactus
