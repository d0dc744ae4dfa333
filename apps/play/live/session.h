#pragma once
// Thread: [control]

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "apps/play/live/controls/level_meter.h"
#include "apps/play/live/controls/live_controls.h"
#include "apps/play/live/performer.h"
#include "apps/play/live/recording.h"
#include "apps/play/live/watched_files.h"
#include "backends/reconnecting_stream.h"
#include "engine/scene/guard_report.h"

namespace tactus::app {

/// The state of a session, for a status line.
struct SessionView {
  bool drives = false;  ///< there is something to arm
  bool armed = false, muted = false;
  StreamState state = StreamState::Stopped;
  struct Level {
    std::string name;
    double peak = 0;  ///< since the last look, full scale = 1
  };
  std::vector<Level> inputs, outputs;
  std::vector<Level> highest_inputs, highest_outputs;  ///< since the start
  Health health;
  std::vector<std::string> guard;  ///< stages that intervened since the last look: "woofer ceiling"
  std::int64_t faults = 0;         ///< of nodes, so far
  std::optional<double> recorded_s;
};

/// [control, one thread] Plays an instrument on a device: opens it, follows edits of its files, and stops
/// without a click.
class Session {
 public:
  /// All must outlive it.
  Session(Performer& performer, Backend& backend, StreamRequest request, bool armed);
  ~Session();

  /// Opens the device; nothing flows yet. Errors: of ReconnectingStream; of the recording.
  [[nodiscard]] Status open();
  /// Errors: of ReconnectingStream.
  [[nodiscard]] Status start() { return stream_->start(); }
  /// Fades out, plays a block of zeros, and ends the take; its errors are appended to `messages`.
  /// The device is closed with the session.
  Status stop(std::vector<std::string>& messages);
  /// To be called about 20 times a second. Returns messages for the user.
  std::vector<std::string> tick();

  void arm(bool on);
  void mute(bool on);
  /// Is there an actuator drive? Audio outputs need no arming.
  bool has_drives() const;
  bool armed() const { return armed_; }
  bool muted() const { return muted_; }
  LiveControls& controls() { return controls_; }
  const StreamGranted& granted() const { return stream_->granted(); }
  /// The device cannot come back in this process.
  bool over() const {
    return stream_ != nullptr && stream_->state() == StreamState::Lost && !granted().comes_back;
  }
  Guarded& guarded() { return guarded_; }
  /// [before `open`] Records takes.
  void record(const std::filesystem::path& wav);
  /// The files of the takes.
  std::vector<std::filesystem::path> takes() const;
  /// [opened] The round-trip latency is known: a warning is given when a gap may have changed it.
  void know_delay() { delay_known_ = true; }
  /// It is unknown, or was measured with other settings.
  void forget_delay();

  /// Levels and guard stages since the last call.
  SessionView look();
  /// Counts of all guards since the start.
  GuardReport guard_report();

 private:
  void fade_out();
  void follow_edits(std::vector<std::string>& messages);
  void report_guard_events(std::vector<std::string>& messages);
  void report_faults(std::vector<std::string>& messages);
  void check_delay_after_gap(std::vector<std::string>& messages);

  Performer& performer_;
  Backend& backend_;
  StreamRequest request_;
  std::vector<GuardedChannel> guards_;
  Guarded guarded_;
  LevelMeter meter_;
  std::unique_ptr<Recording> recording_;
  LiveControls controls_;
  WatchedFiles files_;
  std::unique_ptr<ReconnectingStream> stream_;
  bool armed_, muted_ = false;
  bool edit_waits_ = false;
  bool delay_known_ = false;
  std::vector<double> highest_in_, highest_out_;
  std::vector<GuardCounts> seen_guards_;
  std::vector<FaultCount> reported_faults_;
  std::vector<GuardEvent> events_;
  std::vector<std::string> waiting_messages_;  ///< for the next tick
};

}  // namespace tactus::app
