#pragma once
// Thread: [any, one thread: the network's]

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <random>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "remote/arm_request.h"
#include "remote/remote.h"

namespace tactus {

/// What browsers did so far.
struct PanelCounts {
  std::int64_t messages = 0, refused = 0, orders = 0, scope_frames = 0;
};

/// The protocol of the browser panel, without sockets: docs/panel_protocol.md has its messages. A client is a
/// connection, by number.
class PanelHost {
 public:
  using Clock = std::chrono::steady_clock;
  /// How messages leave. A client that does not take them loses scope frames first.
  struct Sender {
    std::function<void(int client, std::string text)> text;
    std::function<void(int client, std::string bytes)> scope;
  };

  static constexpr std::size_t kLongestMessage = 4096;
  static constexpr int kMostMessages = 400;  ///< a second, of each client

  /// `target` outlives it. `arm_from_elsewhere`: clients of other hosts may arm and unmute.
  PanelHost(RemoteTarget& target, Sender sender, bool arm_from_elsewhere);
  ~PanelHost();

  void connected(int client, bool local);
  void received(int client, std::string_view text, Clock::time_point now);
  /// Drives that it armed are disarmed at once.
  void disconnected(int client);
  /// To be called every 10 ms.
  void tick(Clock::time_point now);
  const PanelCounts& counts() const { return counts_; }

 private:
  struct Client {
    bool local = false;
    double messages_left = kMostMessages;
    ArmRequest arming;
  };
  struct Message;
  using Act = void (PanelHost::*)(const Message&);

  void set(const Message& message);
  void trigger(const Message& message);
  void gesture(const Message& message);
  void request_arm(const Message& message);
  void arm(const Message& message);
  void alive(const Message& message);
  void disarm(const Message& message);
  void mute(const Message& message);
  void scope(const Message& message);
  void levels(const Message& message);
  void bodies(const Message& message);
  void judge(const Message& message);
  void recall(const Message& message);
  void save(const Message& message);
  void learn(const Message& message);
  void request(const Message& message, RemoteRequest::Kind kind, double ramp_s);
  static Act act_of(std::string_view name);

  const RemoteControl* control_of(const Message& message);
  bool may_arm(const Client& client) const { return client.local || arm_from_elsewhere_; }
  void post(const Message& message, RemoteOrder order);
  void error(const Message& message, const std::string& text);
  void send_all(const std::string& text);
  void describe();
  void send_events();
  void send_state(Clock::time_point now);
  void send_scope();

  RemoteTarget& target_;
  Sender sender_;
  bool arm_from_elsewhere_;
  std::map<int, Client> clients_;
  std::shared_ptr<const RemoteDescription> description_;
  std::shared_ptr<const RemoteEdit> edit_;
  std::shared_ptr<const RemoteScope> scope_;
  std::shared_ptr<const RemoteVerdict> verdict_;
  std::optional<int> owner_;  ///< the client that had the drives armed, or asked for it
  int arming_ = 0;            ///< of the owner
  bool owner_armed_ = false;  ///< they were seen armed
  std::optional<int> scope_client_;
  std::set<int> level_clients_, body_clients_;
  std::random_device random_;
  Clock::time_point state_sent_, refilled_;
  PanelCounts counts_;
};

}  // namespace tactus
