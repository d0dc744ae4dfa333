#pragma once

#include <array>
#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <string>

#include "backends/midi_worker.h"

// As JACK's own headers name them.
struct _jack_client;
struct _jack_port;

namespace tactus::jack {

/// One MIDI input port of a client.
struct MidiInPort final : MidiPort {
  _jack_port* handle = nullptr;
  std::string source;                ///< full name of the port that it is connected to
  std::atomic<bool> is_there{true};  ///< the source; once it went away, the port is free for another
};

/// The MIDI input ports midi_1, midi_2, … of a client, one for each source, so that it is known where a
/// message came from. A port is registered when it is first needed, and stays as long as the client, because
/// the audio thread reads it.
class MidiIn {
 public:
  static constexpr std::size_t kMostPorts = 32;

  /// [control & active, may hang] A free port, connected to `source`. Empty: there is none, or the server
  /// refuses.
  std::shared_ptr<MidiInPort> connect(_jack_client* client, const std::string& source);
  /// [control] Ports whose source `is_there` does not find are free.
  void keep(const std::function<bool(const std::string& source)>& is_there);
  /// [realtime] Takes what came in this block.
  void receive(int frames) noexcept;

 private:
  std::shared_ptr<MidiInPort> free_port(_jack_client* client);

  std::mutex mutex_;  ///< of the sources
  std::array<std::shared_ptr<MidiInPort>, kMostPorts> ports_;
  std::atomic<std::size_t> count_{0};  ///< of ports that are complete
};

}  // namespace tactus::jack
