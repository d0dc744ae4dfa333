#pragma once
// Thread: [control]

#include <memory>
#include <string>
#include <vector>

#include "apps/play/live/remote/live_remote.h"
#include "apps/play/live/remote/remote_options.h"

namespace tactus::app {

/// The servers through which clients reach a session, with the target of their orders.
class RemoteServer {
 public:
  virtual ~RemoteServer() = default;
  virtual LiveRemote& target() = 0;
  /// Where it can be reached, a line for each server.
  virtual std::vector<std::string> announcements() const = 0;
  /// What clients did, a line for each server.
  virtual std::vector<std::string> summaries() const = 0;
};

/// nullptr: none is asked for. Throws a CommandError: an address is wrong or in use, or this program was
/// built without a server.
std::unique_ptr<RemoteServer> make_remote_server(const RemoteOptions& options, Session& session,
                                                 Performer& performer, Hertz sample_rate);

}  // namespace tactus::app
