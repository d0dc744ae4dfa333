#pragma once
// Thread: [any]

#include <memory>

namespace tactus::jack {

/// JACK's library deletes all clients of the process when one is opened after their server died (1.9.21,
/// JackLibGlobals::Init), whoever still uses them. So a client holds this from before it is opened until it
/// is closed, and after a death none is opened before all that were open are closed.
class ClientHold {
 public:
  /// Waits up to a second while another client is opened or closed. Empty: it still is, or clients of a
  /// server that died are still open; try again later.
  static std::unique_ptr<ClientHold> acquire();
  ~ClientHold();
  /// The client is open, and will report the death of its server.
  void opened();
  /// The client is going to be closed.
  void closing();
  ClientHold(const ClientHold&) = delete;
  ClientHold& operator=(const ClientHold&) = delete;

 private:
  ClientHold() = default;
  bool calls_ = true;  ///< the library, to open or close the client: no death is reported meanwhile
};

/// The server of the clients that are open now died.
void note_server_death();

}  // namespace tactus::jack
