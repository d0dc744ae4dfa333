#pragma once
// Thread: [control] where not said otherwise.

#include <deque>
#include <memory>
#include <mutex>
#include <vector>

#include "remote/remote.h"

namespace tactus {

/// One target for several servers, each with a thread of its own: every server has all events and its own
/// meters. What acts at once (disarm, mute, keep-alive) waits for no other server.
class SharedRemote {
 public:
  /// `target` outlives it, and it outlives its shares.
  explicit SharedRemote(RemoteTarget& target) : target_(target) {}

  /// For one more server.
  std::unique_ptr<RemoteTarget> share();

 private:
  class Share;
  static constexpr std::size_t kMostEvents = 1024;  ///< that wait for a server; then the oldest are lost

  void collect_events();
  void collect_meters();
  void watch_bodies();

  RemoteTarget& target_;
  std::mutex mutex_;  ///< of the servers' threads
  std::vector<Share*> shares_;
};

}  // namespace tactus
