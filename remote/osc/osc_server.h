#pragma once
// Thread: [control]

#include <memory>
#include <string>

#include "engine/core/error.h"
#include "remote/listen.h"
#include "remote/osc/osc_host.h"
#include "remote/remote.h"

namespace tactus {

/// "9000", "192.168.1.5:9000", "[::1]:9000". Errors, at --osc: Syntax.
Result<ListenOptions> parse_osc_address(const std::string& text);

/// OSC over UDP and its description over HTTP (TCP), both at one port, on a thread of its own that waits for
/// no other.
class OscServer {
 public:
  /// Errors, at --osc: Device, where the system does not give that address or port.
  static Result<std::unique_ptr<OscServer>> open(const ListenOptions& options, RemoteTarget& target);
  virtual ~OscServer() = default;

  virtual int port() const = 0;
  /// "OSC       udp 127.0.0.1:9000, description http://127.0.0.1:9000/"
  virtual std::string announcement() const = 0;
  /// As of a moment ago.
  virtual OscCounts counts() const = 0;
};

}  // namespace tactus
