#pragma once
// Thread: [control]

#include <memory>
#include <string>

#include "engine/core/error.h"
#include "remote/listen.h"
#include "remote/panel/panel_host.h"
#include "remote/remote.h"

namespace tactus {

/// "", "8080", "192.168.1.5:8080". Errors, at --panel: Syntax.
Result<ListenOptions> parse_panel_address(const std::string& text);

/// The browser panel: its pages over HTTP, and one WebSocket for each browser, on a thread of its own that
/// waits for no other. A request must name this server as its host, and come from one of its own pages; a
/// WebSocket needs the token of the link too.
class PanelServer {
 public:
  /// Errors, at --panel: Device, where the system does not give that address or port.
  static Result<std::unique_ptr<PanelServer>> open(const ListenOptions& options, RemoteTarget& target);
  virtual ~PanelServer() = default;

  virtual int port() const = 0;
  /// "http://127.0.0.1:8080/#TOKEN"
  virtual std::string link() const = 0;
  /// As of a moment ago.
  virtual PanelCounts counts() const = 0;
};

}  // namespace tactus
