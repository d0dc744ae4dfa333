#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <future>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "apps/play/live/performer.h"
#include "apps/play/live/remote/live_bodies.h"
#include "apps/play/live/remote/live_scope.h"
#include "apps/play/live/session.h"
#include "engine/core/spsc_queue.h"
#include "engine/rig/preset.h"
#include "engine/runtime/event_watch.h"
#include "remote/keep_alive.h"
#include "remote/order_queue.h"
#include "remote/remote.h"
#include "remote/schedule.h"
#include "remote/stream_clock.h"

namespace tactus::app {

/// The unit in which clients read and set a control: that of its value in the graph file. Units without a
/// name in the table are those of SI.
struct RemoteUnit {
  std::string name;
  Unit unit;
};
/// [any]
RemoteUnit remote_unit(const Unit& unit);

/// A session as clients of other programs and hosts see it. Their controls take the way of keys and MIDI,
/// through the journal of the player.
class LiveRemote final : public RemoteTarget, private ScheduleTarget {
 public:
  using Clock = std::chrono::steady_clock;
  /// An order to arm that waited longer is not obeyed.
  static constexpr std::chrono::seconds kArmWait{1};

  /// [control & stopped] Both outlive it. It observes every block of the session. `screens`: clients show
  /// signals and the graph.
  LiveRemote(Session& session, Performer& performer, Hertz sample_rate, bool screens = false);
  ~LiveRemote() override;

  /// [control, one thread] Obeys the orders that came. To be called some 500 times a second. `earliest`: no
  /// entry is posted for a frame before it.
  void tick(std::int64_t earliest = 0);
  /// [control, one thread] Messages for the user since the last call.
  std::vector<std::string> take_messages() { return std::exchange(messages_, {}); }
  /// [control, one thread] For clients: what is printed.
  void message(const std::string& text) { push_event({.kind = RemoteEvent::Kind::Message}, text); }
  /// [control, one thread] No frame behind it has an entry of this in the queue of the player.
  std::int64_t last_frame() const { return schedule_.last_frame(); }
  /// [any, the stop loop] In each turn: disarms the drives when the client that had them armed is gone.
  void watch(Clock::time_point now) noexcept;
  /// [control, one thread] From packets to the queue of the player, of changes without a time tag.
  struct Delay {
    std::int64_t changes = 0;
    double mean_ms = 0.0, longest_ms = 0.0;
  };
  Delay delay() const { return delay_; }
  /// [control, one thread] Requests since the last call, oldest first.
  std::vector<RemoteRequest> take_requests();
  /// [control, one thread] For clients: the presets.
  void set_presets(std::vector<std::string> names);
  /// [control, one thread] For clients: what moves each control; of MIDI as text.
  void set_sources(std::map<std::string, std::string> midi, std::vector<RigOsc> osc, std::vector<RigHid> hid);
  /// [control, one thread] The next foreign OSC address, axis or button is a request of kind LearntAddress or
  /// LearntHid.
  void learn(bool on) { learning_ = on; }
  /// [control, one thread] All of a preset from the same frame on.
  void apply(const Preset& preset, Seconds ramp);
  /// [control & stopped] What is known of the round-trip latency, for screens.
  void set_latency(std::optional<Seconds> latency, bool measured) {
    latency_ = latency;
    latency_measured_ = measured;
  }

  std::shared_ptr<const RemoteDescription> description() const override;
  bool post(std::span<const RemoteOrder> bundle) override { return orders_.push(bundle); }
  void disarm() noexcept override;
  void mute(bool on) noexcept override;
  bool armed() const noexcept override { return session_.switches().armed(); }
  int disarms() const noexcept override { return session_.switches().disarms(); }
  bool muted() const noexcept override { return session_.switches().muted(); }
  Result<int> order_arm() override;
  void keep_alive(int arming) noexcept override { keep_alive_.refresh(Clock::now(), arming); }
  RemoteMeters take_meters() override;
  bool take_event(RemoteEvent& event) override { return events_.pop(event); }
  std::int64_t late() const noexcept override { return late_; }
  void report(std::string text) override;
  bool request(RemoteRequest request) override;
  bool learn_address(const std::string& address) override;
  bool learn_hid(const RigHid& source) override;
  std::shared_ptr<const RemoteState> state() const override;
  std::shared_ptr<const RemoteEdit> edit() const override;
  std::shared_ptr<const RemoteScope> scope() const override { return scope_ ? scope_->shown() : nullptr; }
  void order_scope(std::uint32_t id, int bin, std::vector<std::string> signals) override;
  std::shared_ptr<const RemoteVerdict> verdict() const override;
  void order_verdict(double delay_s) override;
  void order_levels(bool on) override;
  bool take_scope(ScopeChunk& chunk) override { return scope_ && scope_->take(chunk); }
  void watch_bodies(RemoteWatch watch) override { bodies_.watch(watch); }
  std::shared_ptr<const RemoteBodies> bodies() const override { return bodies_.bodies(); }

 private:
  std::optional<ScheduledControl> control(int number) const override;
  void note(int number, double value) override;
  void gesture(int number, double value) override { (void)performer_.set_gesture(number, value); }
  bool post(const JournalEntry& entry) override { return player().post(entry); }

  Player& player() const { return performer_.instrument(); }
  const std::string& name_of(int number) const;
  void renew();
  void follow_frames();
  void take_orders();
  bool obey_at_once(const RemoteOrder& order);
  void arm(const RemoteOrder& order);
  void not_armed(const std::string& why);
  void publish_controls();
  void report_states();
  void follow_events();
  void follow_bodies();
  void follow_verdict();
  void publish_meters();
  void publish_state();
  void publish_files();
  void draw(RemoteDescription& description);
  void push_event(RemoteEvent event, const std::string& text);
  void measure(const RemoteOrder& order);

  Session& session_;
  Performer& performer_;
  std::shared_ptr<LevelMeter> meter_;
  KeepAlive keep_alive_;
  // Of what acted at once, for the messages.
  std::atomic<bool> learning_{false};
  std::atomic<bool> client_lost_{false}, client_disarmed_{false}, client_muted_{false};
  std::atomic<double> load_{0.0};
  std::vector<std::atomic<double>> guard_;  ///< frames of each stage of each output
  std::atomic<std::int64_t> late_{0};
  OrderQueue orders_;
  SpscQueue<RemoteEvent> events_{256};
  mutable std::mutex mutex_;  ///< of what the control thread replaces:
  std::shared_ptr<const RemoteDescription> description_;
  std::shared_ptr<const RemoteState> state_;
  std::shared_ptr<const RemoteEdit> edit_;
  std::shared_ptr<const RemoteVerdict> verdict_;
  std::optional<double> verdict_order_;  ///< the delay, until it is obeyed
  std::vector<RemoteRequest> requests_;
  std::vector<std::string> reports_;
  EventWatch watch_;
  std::vector<GraphEvent> watched_;  ///< of the control thread
  std::uint64_t watched_version_ = 0;
  LiveBodies bodies_;
  std::unique_ptr<LiveScope> scope_;  ///< nullptr: no client has a screen
  // Of the control thread.
  std::future<std::vector<PictureFile>> files_read_;
  std::atomic<bool> judging_{false};  ///< false ends what `judged_` waits for
  std::future<RemoteVerdict> judged_;
  std::vector<PictureFile> files_;
  std::vector<std::string> presets_;
  std::map<std::string, std::string> midi_;  ///< by control
  std::vector<RigOsc> osc_;
  std::vector<RigHid> hid_;
  bool described_ = false;  ///< nothing of the description has changed since
  std::optional<Seconds> latency_;
  bool latency_measured_ = false;
  StreamClock clock_;
  RemoteSchedule schedule_;
  std::int64_t frame_ = 0;
  int version_ = -1;  ///< of the controls
  bool armed_before_ = false, muted_before_ = false;
  Clock::time_point meters_read_;
  Delay delay_;
  std::vector<std::string> messages_;
  std::vector<RemoteOrder> bundle_;
};

}  // namespace tactus::app
