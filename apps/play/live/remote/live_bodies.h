#pragma once
// Thread: [control, one thread] unless stated otherwise.

#include <chrono>
#include <memory>
#include <mutex>
#include <vector>

#include "engine/runtime/player.h"
#include "remote/remote.h"

namespace tactus::app {

/// The rigid bodies of a session: those of its instrument and, where there is one, of its simulated plant.
class LiveBodies {
 public:
  using Clock = std::chrono::steady_clock;
  struct Impact {
    int world = 0;
    BodyImpact impact;
  };

  /// [control & stopped] `plant`: or nullptr. Both outlive it.
  LiveBodies(Player& instrument, Player* plant);

  const std::vector<RemoteWorld>& worlds() const { return worlds_; }
  /// Obeys the orders that came, follows edits and fetches the bodies: true where the worlds are others now.
  bool tick(Clock::time_point now);
  /// False: there was none since.
  bool take(Impact& impact);

  /// [any]
  void watch(RemoteWatch watch);
  std::shared_ptr<const RemoteBodies> bodies() const;

 private:
  struct Part {
    Player* player = nullptr;
    std::uint64_t version = 0;  ///< of the graph, whose worlds are known
  };

  bool follow_edits();
  void fetch();

  std::vector<Part> parts_;
  std::vector<std::shared_ptr<Node>> nodes_;  ///< that the sources are of, for as long as they are used
  std::vector<BodySource*> sources_;          ///< in the order of the worlds
  std::vector<RemoteWorld> worlds_;
  std::vector<BodyPoses> poses_;
  RemoteWatch watched_;
  Clock::time_point fetched_;
  mutable std::mutex mutex_;  ///< of what other threads order and see:
  RemoteWatch wanted_;
  std::shared_ptr<const RemoteBodies> bodies_;
};

}  // namespace tactus::app
