#pragma once
// Thread: [control]

#include <memory>
#include <string>

#include "apps/play/live/remote/live_remote.h"

namespace tactus::app {

struct RemoteOptions {
  std::string osc;       ///< [ADDRESS:]PORT; empty: no server
  bool osc_arm = false;  ///< clients of other hosts may arm
};

/// The servers through which clients reach a session, with the target of their orders.
class RemoteServer {
 public:
  virtual ~RemoteServer() = default;
  virtual LiveRemote& target() = 0;
  /// Where it can be reached.
  virtual std::string announcement() const = 0;
  /// What clients did.
  virtual std::string summary() const = 0;
};

/// nullptr: none is asked for. Throws a CommandError: the address is wrong or in use, or this program was
/// built without OSC.
std::unique_ptr<RemoteServer> make_remote_server(const RemoteOptions& options, Session& session,
                                                 Performer& performer, Hertz sample_rate);

}  // namespace tactus::app
