#include "backends/jack/client.h"

#include <jack/jack.h>

#include <algorithm>
#include <cerrno>

#include "engine/core/index.h"

namespace tactus::jack {
namespace {

std::string why(jack_status_t status) {
  if ((status & JackServerFailed) != 0) return "no JACK server is running";
  if ((status & JackVersionError) != 0) return "the JACK server has another version";
  return "the JACK server refused another client";
}

Status cannot(const std::string& what, const std::string& remedy) {
  return fail(Errc::Device, "", "JACK cannot " + what, remedy);
}

Client& client(void* self) { return *static_cast<Client*>(self); }

}  // namespace

Result<std::shared_ptr<Client>> Client::open(const std::string& name) {
  silence_library_logs();
  jack_status_t status{};
  jack_client_t* handle = jack_client_open(name.c_str(), JackNoStartServer, &status);
  if (handle == nullptr)
    return fail(Errc::Device, "", why(status), "start one, as in: jackd -d alsa -d hw:0 -r 48000 -p 64");
  return std::shared_ptr<Client>(
      new Client(handle), [](Client* client) { tactus::call_with_timeout([client] { delete client; }); });
}

Client::Client(jack_client_t* handle)
    : handle_(handle), block_frames_(static_cast<int>(jack_get_buffer_size(handle))) {
  set_callbacks();
}

Client::~Client() { jack_client_close(handle_); }

void Client::set_callbacks() {
  jack_set_process_callback(
      handle_, [](jack_nframes_t frames, void* self) { return client(self).process(int(frames)), 0; }, this);
  jack_set_xrun_callback(
      handle_,
      [](void* self) {
        if (client(self).callback_ && client(self).callback_->playing())
          client(self).callback_->gap(Gap::Server);
        return 0;
      },
      this);
  jack_set_buffer_size_callback(
      handle_, [](jack_nframes_t frames, void* self) { return client(self).block_frames_ = int(frames), 0; },
      this);
  jack_set_port_connect_callback(
      handle_, [](jack_port_id_t, jack_port_id_t, int, void* self) { ++client(self).rewirings_; }, this);
  jack_set_port_registration_callback(
      handle_,
      [](jack_port_id_t, int registered, void* self) {
        if (registered == 0) client(self).check_ports();
      },
      this);
  jack_on_info_shutdown(
      handle_, [](jack_status_t, const char*, void* self) { client(self).lost_ = true; }, this);
}

double Client::sample_rate() const { return jack_get_sample_rate(handle_); }

Status Client::add_ports(int inputs, int outputs) {
  const auto add = [this](std::vector<jack_port_t*>& ports, const std::string& kind, unsigned long way) {
    const auto name = kind + std::to_string(ports.size() + 1);
    ports.push_back(jack_port_register(handle_, name.c_str(), JACK_DEFAULT_AUDIO_TYPE, way, 0));
    return ports.back() != nullptr;
  };
  bool all = true;
  for (int c = 0; c < inputs && all; ++c) all = add(inputs_, "in_", JackPortIsInput);
  for (int c = 0; c < outputs && all; ++c) all = add(outputs_, "out_", JackPortIsOutput);
  in_.assign(inputs_.size(), nullptr);
  out_.assign(outputs_.size(), nullptr);
  return all ? Status{} : cannot("register that many ports", "start the server with a larger --port-max");
}

std::string Client::input_port(int channel) const { return jack_port_name(inputs_[index(channel)]); }
std::string Client::output_port(int channel) const { return jack_port_name(outputs_[index(channel)]); }

void Client::play_through(std::unique_ptr<CardCallback> callback, std::vector<Wire> wires) {
  callback_ = std::move(callback);
  wires_ = std::move(wires);
}

Status Client::activate() {
  first_ = true;
  if (jack_activate(handle_) != 0)
    return cannot("start the client", "check that the server is still running");
  for (const auto& wire : wires_)
    if (const int result = jack_connect(handle_, wire.from.c_str(), wire.to.c_str());
        result != 0 && result != EEXIST)
      return cannot("connect '" + wire.from + "' to '" + wire.to + "'",
                    "check with jack_lsp that both exist");
  return {};
}

void Client::deactivate() { jack_deactivate(handle_); }

std::vector<bool> Client::connected() const {
  std::vector<bool> is;
  for (const auto& wire : wires_) {
    const auto w = is.size();
    is.push_back(w < inputs_.size()
                     ? jack_port_connected_to(inputs_[w], wire.from.c_str()) != 0
                     : jack_port_connected_to(outputs_[w - inputs_.size()], wire.to.c_str()) != 0);
  }
  return is;
}

void Client::check_ports() {
  const auto there = [this](const std::string& port) {
    return jack_port_by_name(handle_, port.c_str()) != nullptr;
  };
  if (!std::all_of(wires_.begin(), wires_.end(),
                   [&](const Wire& wire) { return there(wire.from) && there(wire.to); }))
    lost_ = true;
}

void Client::process(int frames) noexcept {
  if (!callback_) return;
  const auto buffer = [frames](jack_port_t* port) {
    return static_cast<float*>(jack_port_get_buffer(port, static_cast<jack_nframes_t>(frames)));
  };
  std::transform(inputs_.begin(), inputs_.end(), in_.begin(), buffer);
  std::transform(outputs_.begin(), outputs_.end(), out_.begin(), buffer);
  note_lost_frames(frames);
  callback_->block(in_.data(), out_.data(), static_cast<int>(out_.size()), frames);
}

/// While a client is late the others go on, unless the server is synchronous: what it could not take is
/// missing on its way through the server's count.
void Client::note_lost_frames(int frames) noexcept {
  const auto now = jack_last_frame_time(handle_);
  const auto lost = static_cast<std::int32_t>(now - next_frame_);
  if (!first_ && lost > 0 && callback_->playing()) callback_->lost(lost);
  first_ = false;
  next_frame_ = now + static_cast<jack_nframes_t>(frames);
}

tl::unexpected<Error> no_answer() {
  return fail(Errc::Device, "", "the JACK server does not respond", "restart it");
}

}  // namespace tactus::jack
