#include <fmt/format.h>
#include <jack/jack.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <utility>

#include "backends/card_callback.h"
#include "backends/find_device.h"
#include "backends/library_calls.h"
#include "engine/core/index.h"

namespace tactus {
namespace {

using Names = std::vector<std::string>;

/// From one port to another, by their full names.
struct Wire {
  std::string from, to;
};

std::string why(jack_status_t status) {
  if ((status & JackServerFailed) != 0) return "no JACK server is running";
  if ((status & JackVersionError) != 0) return "the JACK server has another version";
  return "the JACK server refused another client";
}

Status cannot(const std::string& what, const std::string& remedy) {
  return fail(Errc::Device, "", "JACK cannot " + what, remedy);
}

tl::unexpected<Error> no_answer() {
  return fail(Errc::Device, "", "the JACK server does not respond", "restart it");
}

/// A call that may hang; gives up after two seconds. `call` owns whatever it touches and returns a Result.
template <class Call>
auto ask_server(Call call) -> decltype(call()) {
  if (auto answer = result_with_timeout(std::move(call))) return std::move(*answer);
  return no_answer();
}

/// A client of the running server, closed with its last owner. Any call that waits for the server's answer
/// may hang: such calls are made by `ask_server` and own the client, and it closes itself with the
/// same patience.
class Client {
 public:
  /// [control, may hang] Errors: Device, if no server answers.
  static Result<std::shared_ptr<Client>> open(const std::string& name) {
    silence_library_logs();
    jack_status_t status{};
    jack_client_t* handle = jack_client_open(name.c_str(), JackNoStartServer, &status);
    if (handle == nullptr)
      return fail(Errc::Device, "", why(status), "start one, as in: jackd -d alsa -d hw:0 -r 48000 -p 64");
    return std::shared_ptr<Client>(new Client(handle),
                                   [](Client* client) { call_with_timeout([client] { delete client; }); });
  }
  ~Client() { jack_client_close(handle); }
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;

  /// [control & inactive, may hang] Ports in_1, in_2, … and out_1, out_2, … Errors: Device.
  Status add_ports(int inputs, int outputs) {
    const auto add = [this](std::vector<jack_port_t*>& ports, const std::string& kind, unsigned long way) {
      const auto name = kind + std::to_string(ports.size() + 1);
      ports.push_back(jack_port_register(handle, name.c_str(), JACK_DEFAULT_AUDIO_TYPE, way, 0));
      return ports.back() != nullptr;
    };
    bool all = true;
    for (int c = 0; c < inputs && all; ++c) all = add(inputs_, "in_", JackPortIsInput);
    for (int c = 0; c < outputs && all; ++c) all = add(outputs_, "out_", JackPortIsOutput);
    in_.assign(inputs_.size(), nullptr);
    out_.assign(outputs_.size(), nullptr);
    return all ? Status{} : cannot("register that many ports", "start the server with a larger --port-max");
  }
  std::string input_port(int channel) const { return jack_port_name(inputs_[index(channel)]); }
  std::string output_port(int channel) const { return jack_port_name(outputs_[index(channel)]); }

  /// [control, may hang] Blocks come, and every wire is connected. Errors: Device.
  Status activate() {
    first_ = true;
    if (jack_activate(handle) != 0)
      return cannot("start the client", "check that the server is still running");
    for (const auto& wire : wires)
      if (const int result = jack_connect(handle, wire.from.c_str(), wire.to.c_str());
          result != 0 && result != EEXIST)
        return cannot("connect '" + wire.from + "' to '" + wire.to + "'",
                      "check with jack_lsp that both exist");
    return {};
  }

  /// [control & active] For each wire: is it connected?
  std::vector<bool> connected() const {
    std::vector<bool> is;
    for (const auto& wire : wires) {
      const auto w = is.size();
      is.push_back(w < inputs_.size()
                       ? jack_port_connected_to(inputs_[w], wire.from.c_str()) != 0
                       : jack_port_connected_to(outputs_[w - inputs_.size()], wire.to.c_str()) != 0);
    }
    return is;
  }

  jack_client_t* const handle;
  std::unique_ptr<CardCallback> card;  ///< set before `activate`
  /// It is lost when an end of one goes away. Those to the inputs come first, each channel's in turn.
  std::vector<Wire> wires;
  std::atomic<bool> lost{false};  ///< the server went away, or the other end of a wire did
  std::atomic<int> block_frames;
  std::atomic<int> rewirings{0};  ///< how often wires were connected or disconnected

 private:
  explicit Client(jack_client_t* opened)
      : handle(opened), block_frames(static_cast<int>(jack_get_buffer_size(opened))) {
    jack_set_process_callback(
        handle, [](jack_nframes_t frames, void* self) { return client(self).process(int(frames)), 0; }, this);
    jack_set_xrun_callback(
        handle, [](void* self) { return client(self).note_xrun(), 0; }, this);
    jack_set_buffer_size_callback(
        handle, [](jack_nframes_t frames, void* self) { return client(self).block_frames = int(frames), 0; },
        this);
    jack_set_port_connect_callback(
        handle, [](jack_port_id_t, jack_port_id_t, int, void* self) { ++client(self).rewirings; }, this);
    jack_set_port_registration_callback(
        handle,
        [](jack_port_id_t, int registered, void* self) {
          if (registered == 0) client(self).check_ports();
        },
        this);
    jack_on_info_shutdown(
        handle, [](jack_status_t, const char*, void* self) { client(self).lost = true; }, this);
  }
  static Client& client(void* self) { return *static_cast<Client*>(self); }

  void note_xrun() noexcept {
    if (card && card->playing()) card->gap(Gap::Server);
  }

  void check_ports() {
    const auto there = [this](const std::string& port) {
      return jack_port_by_name(handle, port.c_str()) != nullptr;
    };
    if (!std::all_of(wires.begin(), wires.end(),
                     [&](const Wire& wire) { return there(wire.from) && there(wire.to); }))
      lost = true;
  }

  void process(int frames) noexcept {
    if (!card) return;
    const auto buffer = [frames](jack_port_t* port) {
      return static_cast<float*>(jack_port_get_buffer(port, static_cast<jack_nframes_t>(frames)));
    };
    std::transform(inputs_.begin(), inputs_.end(), in_.begin(), buffer);
    std::transform(outputs_.begin(), outputs_.end(), out_.begin(), buffer);
    note_lost_frames(frames);
    card->block(in_.data(), out_.data(), static_cast<int>(out_.size()), frames);
  }

  /// While a client is late the others go on, unless the server is synchronous: what it could not take is
  /// missing on its way through the server's count.
  void note_lost_frames(int frames) noexcept {
    const auto now = jack_last_frame_time(handle);
    const auto lost_frames = static_cast<std::int32_t>(now - next_frame_);
    if (!first_ && lost_frames > 0 && card->playing()) card->lost(lost_frames);
    first_ = false;
    next_frame_ = now + static_cast<jack_nframes_t>(frames);
  }

  std::vector<jack_port_t*> inputs_, outputs_;
  std::vector<const float*> in_;
  std::vector<float*> out_;
  bool first_ = true;
  std::uint32_t next_frame_ = 0;  ///< where the next block should begin, on the server's clock
};

/// A client of the server with audio ports, by their full names, in the server's order.
struct Card {
  std::string client;
  Names captures;   ///< that sound comes out of
  Names playbacks;  ///< that sound goes into
};

/// `flags` as JACK sees them: sound comes out of an output port.
Names ports(const Client& client, unsigned long flags) {
  Names names;
  const char** found = jack_get_ports(client.handle, nullptr, JACK_DEFAULT_AUDIO_TYPE, flags);
  for (const char** port = found; port != nullptr && *port != nullptr; ++port) names.emplace_back(*port);
  jack_free(found);
  return names;
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

/// All clients with audio ports, those with real hardware behind them first.
std::vector<Card> cards(const Client& client) {
  std::vector<Card> found;
  const auto card = [&](const std::string& port) -> Card& {
    const auto name = port.substr(0, port.find(':'));
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

class JackStream final : public CardStream<Client> {
 public:
  using CardStream::CardStream;
  ~JackStream() override {
    (void)stop();
    line_->card->abandon();
  }

  std::string take_note() override {
    if (const int block = line_->block_frames; block != reported_block_)
      return fmt::format("the JACK block size is now {} frames instead of {}: the delay has changed", block,
                         std::exchange(reported_block_, block));
    if (!running() || line_->lost) return {};
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
    auto started = ask_server([client = line_] { return client->activate(); });
    if (!started) (void)deactivate();
    reported_rewirings_ = line_->rewirings;
    connected_.assign(line_->wires.size(), true);
    return started;
  }
  Status stop_library(bool finished) override {
    if (lost())
      return fail(Errc::Device, "", "the JACK server or the device was disconnected",
                  "reopen the stream when they are available again");
    if (auto status = deactivate(); !status) return status;
    return finished ? Status{} : no_answer();
  }
  Status deactivate() {
    return ask_server([client = line_] { return jack_deactivate(client->handle), Status{}; });
  }

  std::vector<bool> connected_;  ///< as last reported
  int reported_block_ = granted().block_frames, reported_rewirings_ = 0;
};

std::vector<Wire> wires(const Client& client, const StreamRequest& request, const Card& input,
                        const Card& output) {
  std::vector<Wire> wires;
  for (int c = 0; const int from : channels_of(request.in_map, request.in_channels))
    wires.push_back({input.captures[index(from)], client.input_port(c++)});
  for (int c = 0; const int to : channels_of(request.out_map, request.out_channels))
    wires.push_back({client.output_port(c++), output.playbacks[index(to)]});
  return wires;
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
    return ask_server([] {
      return Client::open("tactus-devices").map([](const auto& client) {
        return devices_of(*client, cards(*client));
      });
    });
  }
  Result<std::unique_ptr<Stream>> open(const StreamRequest& request, Guarded& processor) override {
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
    if (auto status = processor.prepare(granted.format); !status) return tl::unexpected(status.error());
    client->wires =
        wires(*client, request, found[index(choice->input.index)], found[index(choice->output.index)]);
    auto unmapped = request;  // our ports are the channels themselves: what is mapped are the wires
    unmapped.in_map = unmapped.out_map = {};
    return std::make_unique<JackStream>(client, std::move(granted), unmapped, processor);
  }
};

}  // namespace

std::unique_ptr<Backend> make_jack_backend() { return std::make_unique<JackBackend>(); }

}  // namespace tactus
