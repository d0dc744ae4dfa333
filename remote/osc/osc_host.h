#pragma once
// Thread: [any, one thread: the network's]

#include <array>
#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <random>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "remote/arm_request.h"
#include "remote/osc/osc_messages.h"
#include "remote/osc/osc_peer.h"
#include "remote/osc/osc_world.h"
#include "remote/osc/osc_world_values.h"
#include "remote/remote.h"

namespace tactus {

/// What clients did so far.
struct OscCounts {
  std::int64_t packets = 0, refused_packets = 0, orders = 0, answers = 0, lost_answers = 0;
};

/// A number that can be read from outside: "/control/strength", "/level/in/microphone".
struct OscReading {
  enum class Kind { Control, Input, Output, Guard, Load, Armed, Muted, Late };
  std::string address;
  Kind kind;
  std::size_t index = 0;  ///< in the description, or in the meters
};

/// All that can be read, in the order of the description.
std::vector<OscReading> osc_readings(const RemoteDescription& description);

/// The address of an event of the instrument: "/event/trigger/hit".
std::string osc_event(const std::string& name);

/// The OSC protocol of an instrument (docs/howto/use_osc.md has its messages), without sockets. Packets act
/// on the target at once or as orders to its control thread. Nothing of it grows without a bound: there are
/// at most kMostClients clients with kMostSubscriptions each, and answers to all of them are limited to
/// kMostAnswers a second.
class OscHost {
 public:
  using Clock = std::chrono::steady_clock;
  using Send = std::function<void(const OscPeer&, std::span<const char>)>;

  static constexpr std::size_t kMostClients = 32, kMostSubscriptions = 16;
  static constexpr int kMostAnswers = 200;
  static constexpr std::chrono::seconds kForgotten{10};
  static constexpr double kMostAhead_s = 10.0;
  static constexpr double kMostRamp_s = 3600.0;

  /// `target` outlives it. `arm_from_elsewhere`: clients of other hosts may arm and unmute.
  OscHost(RemoteTarget& target, Send send, bool arm_from_elsewhere);

  /// `now_s`: of the system clock, since 1970.
  void receive(const OscPeer& from, std::span<const char> packet, Clock::time_point now, double now_s);
  /// Sends what clients subscribed to. To be called every 10 ms.
  void tick(Clock::time_point now, double now_s);
  const OscCounts& counts() const { return counts_; }
  std::size_t clients() const { return clients_.size(); }

 private:
  struct Subscription {
    std::string pattern;
    Clock::duration interval;
    Clock::time_point next;
    bool events = false;                ///< some of those are meant
    std::vector<std::size_t> readings;  ///< in readings_
    std::vector<double> peaks;          ///< inputs, then outputs, since it was sent
  };
  struct Client {
    Clock::time_point heard;
    std::vector<Subscription> subscriptions;
    ArmRequest arming;
  };
  /// A message that is being obeyed.
  struct Context {
    const OscPeer& from;
    Clock::time_point now;
    bool refused = false;  ///< only what acts at once counts: its bundle is refused
    std::vector<RemoteOrder> orders = {};
  };
  using Values = std::vector<OscValue>;

  void obey(const OscMessage& message, Context& context);
  bool obey_at_once(const OscMessage& message, Context& context);
  void obey_mute(const Values& values, Context& context);
  void set(std::string_view name, const Values& values, Context& context);
  bool turn(const OscMessage& message, Context& context);
  void set_one(const RemoteControl& control, const Values& values, Context& context);
  double clamped(const RemoteControl& control, double si, Context& context);
  void trigger(std::string_view name, const Values& values, Context& context);
  void gesture(std::string_view name, const Values& values, Context& context);
  void change_world(const OscMessage& message, Context& context);
  void preset(RemoteRequest::Kind kind, const Values& values, Context& context);
  void request_arm(Context& context);
  void arm(const Values& values, Context& context);
  void subscribe(const Values& values, Context& context);
  void unsubscribe(const Values& values, Context& context);
  void list(Context& context);
  template <class Act>
  void each_control(std::string_view name, Context& context, Act act);

  Client* find_client(const OscPeer& peer, Clock::time_point now);
  Client* add_client(const OscPeer& peer, Clock::time_point now);
  bool may_arm(const OscPeer& peer) const { return peer.local || arm_from_elsewhere_; }
  void renew();
  void choose_readings(Subscription& subscription) const;
  void collect(Subscription& subscription, std::vector<OscMessage>& messages) const;
  double value_of(const OscReading& reading, const Subscription& subscription) const;
  void send_events();
  void send_world(Clock::time_point now);
  void report_armed();
  void send_subscriptions(Clock::time_point now, double now_s);

  void answer(const Context& context, OscMessage message);
  void error(const Context& context, const std::string& text);
  void send(const OscPeer& peer, std::span<const OscMessage> messages, double time_s);

  RemoteTarget& target_;
  Send send_;
  bool arm_from_elsewhere_;
  std::shared_ptr<const RemoteDescription> description_;
  std::vector<OscReading> readings_;
  std::map<OscPeer, Client> clients_;
  std::optional<OscPeer> owner_;  ///< who had the drives armed, or asked for it
  int arming_ = 0;                ///< of the owner
  bool owner_armed_ = false;      ///< as last reported to the owner
  OscWorld world_;
  OscWorldValues world_values_;
  RemoteWatch watch_;      ///< of the bodies, as last ordered
  std::set<int> clamped_;  ///< controls whose last value was outside of the range
  RemoteMeters meters_;
  std::random_device random_;
  double answers_left_ = kMostAnswers;
  Clock::time_point refilled_;
  OscCounts counts_;
};

}  // namespace tactus
