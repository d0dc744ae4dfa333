#pragma once
// Thread: [any]

#include <memory>
#include <string>

struct _jack_client;

namespace tactus {

/// JACK's library deletes all clients of the process when one is opened after their server died (1.9.21,
/// JackLibGlobals::Init), whoever still uses them. So every part of the program that opens clients holds this
/// from before it opens one until its last one is closed, and after a death nothing is opened before all that
/// was open is closed.
class JackClientHold {
 public:
  /// Waits up to a second while another part of the program opens or closes clients. Empty: it still does, or
  /// clients of a server that died are still open; try again later.
  static std::unique_ptr<JackClientHold> acquire();
  /// For clients that do not report the death of their server, as those of RtMidi: an inactive client `name`
  /// reports it. Empty besides: no server answers.
  static std::unique_ptr<JackClientHold> acquire_watched(const std::string& name);
  ~JackClientHold();
  /// The client is open, and will report the death of its server.
  void opened();
  /// The clients are going to be closed.
  void closing();
  JackClientHold(const JackClientHold&) = delete;
  JackClientHold& operator=(const JackClientHold&) = delete;

 private:
  JackClientHold() = default;
  bool calls_ = true;  ///< the library, to open or close a client: no death is reported meanwhile
  _jack_client* watch_ = nullptr;
};

/// The server of the clients that are open now died.
void note_jack_server_death();
/// It did: whoever has clients open closes them now.
bool jack_clients_must_close();

}  // namespace tactus
