#pragma once

#include <chrono>
#include <memory>
#include <mutex>

#include "backends/jack/client.h"
#include "backends/midi.h"

namespace tactus::jack {

/// [any] The client of the stream that plays.
class PlayingClient {
 public:
  void set(const std::shared_ptr<Client>& client) {
    const std::lock_guard lock{mutex_};
    client_ = client;
  }
  /// Empty: none plays, or its server or device went away.
  std::shared_ptr<Client> get() {
    const std::lock_guard lock{mutex_};
    auto client = client_.lock();
    return client && !client->lost ? client : nullptr;
  }

 private:
  std::mutex mutex_;
  std::weak_ptr<Client> client_;
};

/// [control] MIDI inputs as ports of the client that plays: a second client of the process would be deleted
/// by JACK's library when the first one is opened again after a death of the server. An id is "jack:" and the
/// full name of the source.
std::shared_ptr<MidiInputs> make_midi_inputs(std::shared_ptr<PlayingClient> playing,
                                             std::chrono::milliseconds interval);

}  // namespace tactus::jack
