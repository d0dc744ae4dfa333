#pragma once
// Thread: [any, one thread: the network's]

#include <chrono>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "remote/osc/osc_peer.h"
#include "remote/osc/osc_world.h"

namespace tactus {

/// What clients asked DIMPLE's messages to be told: "/world/NAME/position/get", once or at intervals, and
/// "/world/collide". Values are those after the last step.
class OscWorldValues {
 public:
  using Clock = std::chrono::steady_clock;
  using Send = std::function<void(const OscPeer&, OscMessage)>;
  static constexpr std::size_t kMostGets = 64;  ///< of a client
  static constexpr std::chrono::milliseconds kLeastInterval{10};
  /// Before it answers once: what was sent before has then taken effect.
  static constexpr std::chrono::milliseconds kSettled{20};
  /// How long bodies are watched after a message, and a value that is not known yet is waited for.
  static constexpr std::chrono::seconds kWatched{10}, kPatience{1};

  /// Whether it is one of these messages.
  static bool is_question(std::string_view address);
  /// Errors: UnknownName, BadArgument, OutOfRange.
  Status ask(const OscPeer& peer, const OscMessage& message, const OscWorld& world,
             const RemoteDescription& description, Clock::time_point now);
  /// Any message for a world came: the bodies are watched for a while.
  void touch(Clock::time_point now) { watch_until_ = now + kWatched; }
  void forget(const OscPeer& peer);

  RemoteWatch wanted(Clock::time_point now) const;
  /// Answers what is due. To be called every 10 ms.
  void tick(const OscWorld& world, const RemoteDescription& description, const RemoteBodies* bodies,
            Clock::time_point now, const Send& send);
  void impact(const RemoteEvent& event, const OscWorld& world, const RemoteDescription& description,
              const Send& send) const;

 private:
  struct Get {
    std::string object, value;
    bool magnitude = false;
    Clock::duration interval{};  ///< 0: once
    Clock::time_point next, asked;
  };
  struct Client {
    std::vector<Get> gets;
    bool all_collisions = false;
    std::set<std::string> collisions;  ///< of these objects
  };

  Status ask_value(const OscPeer& peer, const OscMessage& message, const OscWorld& world,
                   const RemoteDescription& description, Clock::time_point now);
  Status ask_collisions(const OscPeer& peer, const OscMessage& message, const OscWorld& world,
                        const RemoteDescription& description);

  std::map<OscPeer, Client> clients_;
  Clock::time_point watch_until_;
};

}  // namespace tactus
