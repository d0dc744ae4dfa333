#include "backends/jack/client.h"

#include <jack/jack.h>

#include <algorithm>
#include <cerrno>
#include <utility>

#include "backends/midi_output.h"
#include "engine/core/every_block.h"
#include "engine/core/index.h"

namespace tactus::jack {
namespace {

std::string why(jack_status_t status) {
  if ((status & JackServerFailed) != 0) return "no JACK server is running";
  if ((status & JackVersionError) != 0) return "the JACK server has another version";
  return "the JACK server refused another client";
}

template <class Condition>
bool any_end(const std::vector<Wire>& wires, Condition holds) {
  return std::ranges::any_of(wires, [&](const Wire& wire) { return holds(wire.from) || holds(wire.to); });
}

}  // namespace

Names names_of(const char** listed) {
  Names names;
  for (const char** name = listed; name != nullptr && *name != nullptr; ++name) names.emplace_back(*name);
  jack_free(listed);
  return names;
}

Status cannot(const std::string& what, const std::string& remedy) {
  return fail(Errc::Device, "", "JACK cannot " + what, remedy);
}

tl::unexpected<Error> no_answer() {
  return fail(Errc::Device, "", "the JACK server does not respond", "restart it");
}

Result<std::shared_ptr<Client>> Client::open(const std::string& name) {
  silence_library_logs();
  auto hold = ClientHold::acquire();
  if (!hold)
    return fail(Errc::Device, "", "another part of the program still waits for the JACK server",
                "restart the server if this persists");
  jack_status_t status{};
  jack_client_t* handle = jack_client_open(name.c_str(), JackNoStartServer, &status);
  if (handle == nullptr)
    return fail(Errc::Device, "", why(status), "start one, as in: jackd -d alsa -d hw:0 -r 48000 -p 64");
  return std::shared_ptr<Client>(new Client(handle, std::move(hold)),
                                 [](Client* client) { call_with_timeout([client] { delete client; }); });
}

Client::Client(jack_client_t* opened, std::unique_ptr<ClientHold> hold)
    : handle(opened),
      sample_rate(static_cast<int>(jack_get_sample_rate(opened))),
      block_frames(static_cast<int>(jack_get_buffer_size(opened))),
      hold_(std::move(hold)) {
  set_callbacks();
  hold_->opened();
}

Client::~Client() {
  hold_->closing();
  jack_client_close(handle);
}

void Client::set_callbacks() {
  jack_set_process_callback(
      handle, [](jack_nframes_t frames, void* self) { return client(self).process(int(frames)), 0; }, this);
  jack_set_xrun_callback(
      handle, [](void* self) { return client(self).note_xrun(), 0; }, this);
  jack_set_buffer_size_callback(
      handle, [](jack_nframes_t frames, void* self) { return client(self).block_frames = int(frames), 0; },
      this);
  jack_set_sample_rate_callback(
      handle, [](jack_nframes_t rate, void* self) { return client(self).note_rate(int(rate)), 0; }, this);
  jack_set_freewheel_callback(
      handle, [](int starting, void* self) { client(self).freewheels_ = starting != 0; }, this);
  jack_set_port_connect_callback(
      handle,
      [](jack_port_id_t from, jack_port_id_t to, int connected, void* self) {
        connected != 0 ? client(self).note_connection(from, to) : client(self).note_disconnection(from, to);
        ++client(self).rewirings;
      },
      this);
  jack_set_port_registration_callback(
      handle,
      [](jack_port_id_t port, int registered, void* self) {
        if (registered == 0) client(self).note_removal(port);
      },
      this);
  jack_set_port_rename_callback(
      handle,
      [](jack_port_id_t port, const char* before, const char*, void* self) {
        client(self).note_rename(port, before);
      },
      this);
  jack_on_info_shutdown(
      handle,
      [](jack_status_t, const char*, void* self) {
        note_server_death();
        client(self).lost = true;
      },
      this);
}

Status Client::add_ports(int inputs, int outputs) {
  const std::lock_guard lock{requests_};
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
  return all ? Status{}
             : cannot("register that many ports",
                      "check that the server still runs, or start it with a larger --port-max");
}

std::string Client::input_port(int channel) const { return jack_port_name(inputs_[index(channel)]); }
std::string Client::output_port(int channel) const { return jack_port_name(outputs_[index(channel)]); }

Status Client::activate() {
  const std::lock_guard lock{requests_};
  first_ = true;
  if (jack_activate(handle) != 0) return cannot("start the client", "check that the server is still running");
  for (const auto& wire : wires)
    if (const int result = jack_connect(handle, wire.from.c_str(), wire.to.c_str());
        result != 0 && result != EEXIST)
      return cannot("connect '" + wire.from + "' to '" + wire.to + "'",
                    "check with jack_lsp that both exist");
  return {};
}

void Client::deactivate() {
  const std::lock_guard lock{requests_};
  jack_deactivate(handle);
}

std::vector<OtherWriter> Client::other_writers() const {
  std::vector<OtherWriter> found;
  for (std::size_t c = 0; c < outputs_.size(); ++c) {
    const std::string ours = jack_port_name(outputs_[c]);
    const auto& assigned = wires[inputs_.size() + c].to;
    const int output = static_cast<int>(c);
    for (auto& from : connections_of(assigned))
      if (from != ours) found.push_back({output, std::move(from), assigned});
    for (auto& to : connections_of(ours))
      if (to != assigned && is_of_device(jack_port_by_name(handle, to.c_str())))
        found.push_back({output, ours, std::move(to)});
  }
  return found;
}

std::vector<OtherWriter> Client::take_passing_writers() {
  const std::lock_guard lock{passing_mutex_};
  return std::exchange(passing_writers_, {});
}

/// A writer may come and go between two looks at the connections.
void Client::note_connection(std::uint32_t from, std::uint32_t to) {
  const auto* writes = jack_port_by_id(handle, from);
  const auto* reads = jack_port_by_id(handle, to);
  if (writes == nullptr || reads == nullptr) return;
  const std::string source = jack_port_name(writes), target = jack_port_name(reads);
  for (std::size_t c = 0; c < outputs_.size(); ++c) {
    const bool ours = source == jack_port_name(outputs_[c]),
               assigned = target == wires[inputs_.size() + c].to;
    if (ours == assigned || (ours && !is_of_device(reads))) continue;
    const std::lock_guard lock{passing_mutex_};
    passing_writers_.push_back({static_cast<int>(c), source, target});
  }
}

void Client::note_disconnection(std::uint32_t from, std::uint32_t to) {
  const auto* writes = jack_port_by_id(handle, from);
  const auto* reads = jack_port_by_id(handle, to);
  const auto ours = std::find(outputs_.begin(), outputs_.end(), writes);
  if (reads == nullptr || ours == outputs_.end()) return;
  const auto channel = static_cast<std::size_t>(ours - outputs_.begin());
  if (jack_port_name(reads) == wires[inputs_.size() + channel].to) ++output_cuts;
}

Names Client::connections_of(const std::string& port) const {
  const auto* found = jack_port_by_name(handle, port.c_str());
  return found == nullptr ? Names{} : names_of(jack_port_get_all_connections(handle, found));
}

/// Anything may be behind a port of hardware, and behind each one of the client that is the device.
bool Client::is_of_device(const _jack_port* port) const {
  if (port == nullptr) return false;
  if ((jack_port_flags(port) & JackPortIsPhysical) != 0) return true;
  const auto client = client_of(jack_port_name(port));
  return std::any_of(wires.begin() + static_cast<std::ptrdiff_t>(inputs_.size()), wires.end(),
                     [&](const auto& wire) { return client_of(wire.to) == client; });
}

Names Client::midi_sources() const {
  auto sources = names_of(jack_get_ports(handle, nullptr, JACK_DEFAULT_MIDI_TYPE, JackPortIsOutput));
  std::erase_if(sources, is_own_output);
  return sources;
}

std::string Client::id_of(const std::string& name) {
  const std::lock_guard lock{requests_};
  char* id = jack_get_uuid_for_client_name(handle, name.c_str());
  std::string text = id == nullptr ? "" : id;
  jack_free(id);
  return text;
}

std::shared_ptr<MidiInPort> Client::connect_midi(const std::string& source) {
  const std::lock_guard lock{requests_};
  return lost ? nullptr : midi_.connect(handle, source);
}

std::vector<bool> Client::connected() const {
  std::vector<bool> is;
  for (const auto& wire : wires) {
    const auto w = is.size();
    is.push_back(w < inputs_.size()
                     ? jack_port_connected_to(inputs_[w], wire.from.c_str()) != 0
                     : jack_port_connected_to(outputs_[w - inputs_.size()], wire.to.c_str()) != 0);
  }
  return is;
}

/// Times and slew rates of the guard are those of the rate that was granted: nothing plays at another.
void Client::note_rate(int rate) noexcept {
  if (rate == sample_rate) return;
  new_rate = rate;
  lost = true;
}

void Client::note_xrun() noexcept {
  if (card && card->playing()) card->gap(Gap::Server, CardCallback::GapLength::Counted);
}

/// A client that closes removes its ports after this notification, one that dies before.
void Client::note_removal(std::uint32_t port) {
  const auto* going = jack_port_by_id(handle, port);
  const auto is_there = [&](const std::string& name) {
    const auto* found = jack_port_by_name(handle, name.c_str());
    return found != nullptr && (going == nullptr || name != jack_port_name(going));
  };
  if (any_end(wires, [&](const std::string& name) { return !is_there(name); })) lost = true;
  midi_.keep(is_there);
}

/// Wires are found again by names, so one that changes hands may lead to another actuator.
void Client::note_rename(std::uint32_t port, const std::string& before) {
  const auto* renamed = jack_port_by_id(handle, port);
  if (renamed == nullptr || renames == nullptr) return;
  const std::string now = jack_port_name(renamed);
  const auto client_name = client_of(now) + ":";
  const auto was = before.starts_with(client_name) ? before : client_name + before;
  if (!any_end(wires, [&](const std::string& name) { return name == was || name == now; })) return;
  ++*renames;
  lost = true;
}

TACTUS_EVERY_BLOCK void Client::process(int frames) noexcept {
  if (!card) return;
  midi_.receive(frames);
  const auto buffer = [frames](jack_port_t* port) {
    return static_cast<float*>(jack_port_get_buffer(port, static_cast<jack_nframes_t>(frames)));
  };
  std::transform(inputs_.begin(), inputs_.end(), in_.begin(), buffer);
  std::transform(outputs_.begin(), outputs_.end(), out_.begin(), buffer);
  const bool suspended = freewheels_ || new_rate != 0;
  card->suspend(suspended);
  first_ = first_ || suspended;  // the server's count jumps
  note_lost_frames(frames);
  card->block(in_.data(), out_.data(), static_cast<int>(out_.size()), frames);
}

/// While a client is late the others go on, unless the server is synchronous: what it could not take is
/// missing on its way through the server's count.
void Client::note_lost_frames(int frames) noexcept {
  const auto now = jack_last_frame_time(handle);
  const auto lost_frames = static_cast<std::int32_t>(now - next_frame_);
  if (!first_ && lost_frames > 0 && card->playing()) card->lost(lost_frames);
  first_ = false;
  next_frame_ = now + static_cast<jack_nframes_t>(frames);
}

}  // namespace tactus::jack
