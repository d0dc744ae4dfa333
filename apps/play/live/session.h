#pragma once

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "apps/play/live/controls/knobs.h"
#include "apps/play/live/controls/level_meter.h"
#include "apps/play/live/performer.h"
#include "apps/play/live/recording.h"
#include "apps/play/live/watched_files.h"
#include "backends/reconnecting_stream.h"
#include "engine/scene/guard_report.h"

namespace tactus::app {

/// How a session stands, for a status line.
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
  std::vector<std::string> guard;  ///< what it was busy with since the last look: "woofer ceiling"
  std::int64_t faults = 0;         ///< of nodes, so far
  std::optional<double> recorded_s;
};

/// Something that sounds on a device: opens it, plays, follows its files, and stops without a click. All
/// functions are for one control thread.
class Session {
 public:
  /// All must outlive it.
  Session(Performer& performer, Backend& backend, StreamRequest request, bool armed);
  ~Session();

  /// Opens the device; nothing flows yet. Errors: of KeptStream; of the recording.
  [[nodiscard]] Status open();
  /// Errors: of KeptStream.
  [[nodiscard]] Status start() { return stream_->start(); }
  /// Fades out and plays a block of zeros, and ends the take; what did not go well with it goes to `words`.
  /// The device is closed with the session.
  Status stop(std::vector<std::string>& words);
  /// Call it about 20 times a second. What happened, in words.
  std::vector<std::string> tick();

  void arm(bool on);
  void mute(bool on);
  /// Does anything move? Sound alone needs no arming.
  bool has_drives() const;
  bool armed() const { return armed_; }
  bool muted() const { return muted_; }
  Knobs& knobs() { return knobs_; }
  const StreamGranted& granted() const { return stream_->granted(); }
  /// The device went away for good: only ending is left.
  bool over() const {
    return stream_ != nullptr && stream_->state() == StreamState::Lost && !granted().comes_back;
  }
  Guarded& guarded() { return guarded_; }
  /// [before `open`] Keeps all of it in takes.
  void record(const std::filesystem::path& wav);
  /// The files of the takes.
  std::vector<std::filesystem::path> takes() const;
  /// [opened] The card's delay was measured: it is told when it may be another.
  void know_delay() { delay_known_ = true; }
  /// It was not, or not for what was granted.
  void forget_delay();

  /// Levels and the guard's work start anew with every look.
  SessionView look();
  /// What the guards had to do in all.
  GuardReport guard_report();

 private:
  void fade_out();
  void follow_edits(std::vector<std::string>& words);
  void tell_guard_events(std::vector<std::string>& words);
  void tell_faults(std::vector<std::string>& words);
  void doubt_delay(std::vector<std::string>& words);

  Performer& performer_;
  Backend& backend_;
  StreamRequest request_;
  std::vector<GuardedChannel> guards_;
  Guarded guarded_;
  LevelMeter meter_;
  std::unique_ptr<Recording> recording_;
  Knobs knobs_;
  WatchedFiles files_;
  std::unique_ptr<KeptStream> stream_;
  bool armed_, muted_ = false;
  bool edit_waits_ = false;
  bool delay_known_ = false;
  std::vector<double> highest_in_, highest_out_;
  std::vector<GuardCounts> seen_guards_;
  std::vector<FaultCount> told_faults_;
  std::vector<GuardEvent> events_;
  std::vector<std::string> waiting_words_;  ///< for the next tick
};

}  // namespace tactus::app
