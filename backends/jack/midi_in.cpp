#include "backends/jack/midi_in.h"

#include <jack/jack.h>
#include <jack/midiport.h>

#include <algorithm>
#include <cerrno>

namespace tactus::jack {

std::shared_ptr<MidiInPort> MidiIn::connect(jack_client_t* client, const std::string& source) {
  const auto port = free_port(client);
  if (port == nullptr) return nullptr;
  {
    const std::lock_guard lock{mutex_};
    port->source = source;
    port->is_there = true;
  }
  const int result = jack_connect(client, source.c_str(), jack_port_name(port->handle));
  if (result == 0 || result == EEXIST) return port;
  port->is_there = false;
  return nullptr;
}

std::shared_ptr<MidiInPort> MidiIn::free_port(jack_client_t* client) {
  const auto count = count_.load();
  const auto end = ports_.begin() + static_cast<std::ptrdiff_t>(count);
  const auto unused = std::find_if(ports_.begin(), end, [](const auto& port) { return !port->is_there; });
  if (unused != end) return *unused;
  if (count == kMostPorts) return nullptr;
  auto port = std::make_shared<MidiInPort>();
  const auto name = "midi_" + std::to_string(count + 1);
  port->handle = jack_port_register(client, name.c_str(), JACK_DEFAULT_MIDI_TYPE, JackPortIsInput, 0);
  if (port->handle == nullptr) return nullptr;
  ports_[count] = port;
  count_.store(count + 1);
  return port;
}

void MidiIn::keep(const std::function<bool(const std::string&)>& is_there) {
  const std::lock_guard lock{mutex_};
  for (std::size_t p = 0; p < count_.load(); ++p)
    if (!is_there(ports_[p]->source)) ports_[p]->is_there = false;
}

void MidiIn::receive(int frames) noexcept {
  const auto count = count_.load(std::memory_order_acquire);
  for (std::size_t p = 0; p < count; ++p) {
    void* const buffer = jack_port_get_buffer(ports_[p]->handle, static_cast<jack_nframes_t>(frames));
    if (buffer == nullptr) continue;
    const auto events = jack_midi_get_event_count(buffer);
    for (jack_nframes_t e = 0; e < events; ++e)
      if (jack_midi_event_t event{}; jack_midi_event_get(&event, buffer, e) == 0)
        receive_midi(*ports_[p], {event.buffer, event.size});
  }
}

}  // namespace tactus::jack
