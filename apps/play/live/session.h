#pragma once
// Thread: [control] unless stated otherwise

#include <algorithm>
#include <atomic>
#include <cmath>
#include <filesystem>
#include <functional>
#include <future>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "apps/play/live/controls/drive_keys.h"
#include "apps/play/live/controls/live_controls.h"
#include "apps/play/live/edit_reader.h"
#include "apps/play/live/performer.h"
#include "apps/play/live/tap_gate.h"
#include "backends/reconnecting_stream.h"
#include "backends/take/take_recorder.h"
#include "engine/core/index.h"
#include "engine/dsp/simd/peak.h"
#include "engine/guard/guarded.h"
#include "engine/scene/guard_report.h"

namespace tactus::app {

/// The highest sample of each channel since the last call, and another tap behind it.
class LevelMeter final : public BlockTap {
 public:
  LevelMeter(int inputs, int outputs) : inputs_(index(inputs)), outputs_(index(outputs)) {}

  /// [control & stopped] It observes everything too, and outlives this or is removed with nullptr.
  void set_next(BlockTap* next) { next_ = next; }

  void applied(const JournalEntry& entry) noexcept TACTUS_NONBLOCKING override {
    if (next_ != nullptr) next_->applied(entry);
  }
  void observe(const BlockIo& io, std::int64_t first_frame) noexcept TACTUS_NONBLOCKING override {
    for (std::size_t c = 0; c < inputs_.size(); ++c) raise(inputs_[c], io.in[c], io.frames);
    for (std::size_t c = 0; c < outputs_.size(); ++c) raise(outputs_[c], io.out[c], io.frames);
    if (next_ != nullptr) next_->observe(io, first_frame);
  }

  /// [control, one thread] Full scale = 1; the next call starts anew.
  std::vector<double> take_inputs() { return take(inputs_); }
  std::vector<double> take_outputs() { return take(outputs_); }

 private:
  using Peaks = std::vector<std::atomic<double>>;

  static void raise(std::atomic<double>& peak, const double* samples, int frames) noexcept {
    const double so_far = peak.load(std::memory_order_relaxed);
    peak.store(highest_magnitude(samples, frames, so_far), std::memory_order_relaxed);
  }
  static std::vector<double> take(Peaks& peaks) {
    std::vector<double> levels;
    for (auto& peak : peaks) levels.push_back(peak.exchange(0.0, std::memory_order_relaxed));
    return levels;
  }

  Peaks inputs_, outputs_;
  BlockTap* next_ = nullptr;
};

/// The state of a session, for a status line.
struct SessionView {
  bool drives = false;  ///< there is something to arm: a drive, or sound that feedback disarmed
  bool armed = false, muted = false;
  StreamState state = StreamState::Stopped;
  struct Level {
    std::string name;
    double peak = 0;     ///< since the last view, full scale = 1
    double highest = 0;  ///< since the start
  };
  std::vector<Level> inputs, outputs;
  Health health;
  std::vector<std::string> guard;  ///< stages that intervened since the last view: "woofer ceiling"
  std::int64_t faults = 0;         ///< of nodes, so far
  std::optional<double> recorded_s;
};

/// [control] What to report of a recording, each once: that it stopped, or that frames were dropped.
class RecordingMonitor {
 public:
  std::vector<std::string> update(const TakeStatus& status);

 private:
  std::int64_t reported_dropped_ = 0;
  bool reported_error_ = false;
};

/// The settings of the card that a round-trip latency was measured with; it is valid for no others.
struct DelaySettings {
  std::optional<int> block, periods;  ///< nothing: any
  bool padded = false;                ///< frames were added to it, as many as were missing

  /// Why it is not valid for what was granted; empty: it is.
  std::string why_invalid(const StreamGranted& granted) const;
};

/// [control, one thread] Plays an instrument on a device: opens it, follows edits of its files, and stops
/// without a click. `tick` waits for no file. A device that returns, or goes on, other than it was is
/// disarmed.
class Session {
 public:
  /// All must outlive it.
  Session(Performer& performer, Backend& backend, StreamRequest request, bool armed,
          const DeadMansSwitch* dead_man = nullptr);
  ~Session();

  /// [before start] Drives may be armed although other programs write to their ports.
  void share_ports(bool on) { shared_ports_ = on; }
  /// [before start] `meter` observes every block too.
  void add_meter(std::shared_ptr<LevelMeter> meter);
  /// Called in `tick` for every event of the guard, with its text.
  void on_guard_event(std::function<void(const GuardEvent&, const std::string&)> call) {
    on_guard_event_ = std::move(call);
  }
  /// Called in `tick` for every edit, with its errors: none where it was taken over.
  void on_edit(std::function<void(const std::vector<Error>&)> call) { on_edit_ = std::move(call); }
  /// Opens the device; nothing flows yet. `record`: records takes into this WAV file, empty: into none. A
  /// stream that begins again is another take: take.wav, take-2.wav and so on. Errors: of ReconnectingStream.
  [[nodiscard]] Status open(const std::filesystem::path& record);
  /// Errors: of ReconnectingStream; of TakeRecorder::start.
  [[nodiscard]] Status start();
  /// Fades out, plays a block of zeros, and ends the take. The device is closed with the session.
  Status stop();
  /// To be called about 20 times a second.
  void tick();
  /// Blocks flow, and no edit waits: an entry that is posted now applies to the version that plays.
  bool plays() const {
    return stream_->state() == StreamState::Running && !performer_.instrument().replacing();
  }
  /// While it plays: posts the values of controls that changed.
  void send_controls() { controls_.send(); }
  /// Records from now on, into this WAV file or, where takes of it were recorded before, into the next one of
  /// its name. A take replays only from frame 0 of its stream: the outputs fade out, the device is reopened,
  /// and the instrument starts again from rest, its controls where they are. While the device is away, the
  /// take begins when it returns. A take that cannot be written is reported, and `recording` is false then.
  /// Errors: BadArgument while no blocks come or an edit is applied; of ReconnectingStream::restart.
  [[nodiscard]] Status start_recording(const std::filesystem::path& wav);
  /// Ends the take; what plays goes on. The files are complete when `tick` reports it.
  void stop_recording();
  bool recording() const { return !record_.empty(); }
  /// Messages for the user since the last call.
  std::vector<std::string> take_messages() { return std::exchange(messages_, {}); }

  /// true: obeys the order to arm that the stop loop gave, unless it was taken back meanwhile. Errors:
  /// Device, where another program writes to the port of a drive; BadArgument, where the padding is unknown
  /// for the device as it is now; the order is void then. Disarming always succeeds.
  Status arm(bool on);
  void mute(bool on) { switches_.mute(on); }
  /// [any] For the stop loop.
  DriveSwitches& switches() { return switches_; }
  /// [any] The stop loop calls it when `tick` has not run for 0.5 s, so that nothing watches the device:
  /// disarms the drives. Does nothing while `tick` may be reopening a lost device.
  void control_stalled();
  /// The longest time that fading out takes.
  Seconds closing_time() const { return guarded_.closing_time(); }
  /// Is there something to arm? Audio outputs need it only after feedback.
  bool has_drives() const { return view_.drives; }
  bool armed() const { return switches_.armed(); }
  bool muted() const { return switches_.muted(); }
  LiveControls& controls() { return controls_; }
  const LiveControls& controls() const { return controls_; }
  /// [opened]
  GuardCounts guard_counts(int output) const noexcept { return guarded_.counts(output); }
  /// 99.9th percentile of the share of a block's time that computing it takes.
  double high_load() const { return stream_->health().high_load; }
  const StreamGranted& granted() const { return stream_->granted(); }
  bool opened() const { return stream_ != nullptr; }
  /// [opened]
  StreamState state() const { return stream_->state(); }
  Health health() const { return stream_->health(); }
  /// [opened] What an output uses of its limits of heat and excursion; nothing: it has no such limit.
  struct GuardUse {
    std::optional<double> coil, body, excursion;
  };
  GuardUse guard_use(int output) const;
  /// The device cannot come back in this process.
  bool over() const {
    return stream_ != nullptr && stream_->state() == StreamState::Lost && !granted().comes_back;
  }
  /// The files of the takes, oldest first.
  const std::vector<std::filesystem::path>& takes() const { return takes_; }
  /// [opened] The settings of the known round-trip latency: a warning is given when a gap or another setting
  /// may have changed it. Nothing: it is unknown.
  void set_delay(std::optional<DelaySettings> settings);

  /// Levels and guard stages since the last call. Stays as it is until the next one.
  const SessionView& view();
  /// Counts of all guards since the start.
  GuardReport guard_report();

 private:
  void fade_out();
  void follow_edits();
  void take_over(const Edit& edit);
  void report_guard_events();
  void report_faults();
  void report_recording();
  void device_returned(const Return& back);
  void disarm(const std::string& why);
  Status may_arm() const;
  bool writers_may_be_hidden() const;
  std::vector<OtherWriter> writers_to_drives() const;
  void watch_writers();
  void set_delay_known(bool known);
  void check_delay();
  void check_delay_after_gap();
  Status begin_take();
  void end_take();
  void report_ended_take();
  void note_edit();

  Performer& performer_;
  Backend& backend_;
  StreamRequest request_;
  Guarded guarded_;
  DriveSwitches switches_;
  TapGate take_;  ///< to the recorder
  LevelMeter meter_;
  std::shared_ptr<LevelMeter> second_meter_;  ///< or nullptr; in front of `meter_`
  LiveControls controls_;
  std::unique_ptr<ReconnectingStream> stream_;
  SessionView view_;
  bool delay_known_ = false, shared_ports_ = false;
  std::atomic<bool> device_runs_{false};  ///< when `tick` looked last
  std::atomic<bool> control_stalled_{false};
  std::optional<DelaySettings> delay_;
  std::vector<OtherWriter> writers_;  ///< as last reported
  std::vector<std::string> notes_;    ///< messages that follow those of the stream
  std::vector<GuardCounts> seen_guards_;
  std::map<std::string, std::int64_t> fault_counts_;  ///< by node
  std::vector<GuardEvent> events_;
  std::vector<std::string> messages_;
  std::filesystem::path record_;      ///< where takes are recorded; empty: nowhere
  std::filesystem::path first_take_;  ///< of the name that takes were recorded to last
  int takes_of_name_ = 0;
  std::vector<std::filesystem::path> takes_;
  std::unique_ptr<TakeRecorder> recorder_;
  std::future<std::vector<std::string>> ended_take_;  ///< that is being completed: what to report of it
  RecordingMonitor recording_;
  std::function<void(const GuardEvent&, const std::string&)> on_guard_event_;
  std::function<void(const std::vector<Error>&)> on_edit_;
  EditReader edits_;
};

/// Prints what a session that has stopped did; `view`: its last one. For people, or all of it as one object.
void print_report(Session& session, const SessionView& view, Performer& performer, bool as_json);

}  // namespace tactus::app
