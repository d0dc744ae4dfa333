#pragma once

#include <atomic>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "engine/core/block_io.h"
#include "engine/core/journal.h"
#include "engine/core/spsc_queue.h"
#include "engine/guard/dead_mans_switch.h"
#include "engine/guard/drive_guard.h"
#include "engine/guard/sensor_watch.h"

namespace tactus {

/// Which source decided one limit of an output; for reports and takes.
struct LimitOrigin {
  std::string limit;   ///< "ceiling"
  double value = 0.0;  ///< SI
  std::string source;  ///< "[outputs] woofer"
  std::optional<double> raised_from = {};

  bool operator==(const LimitOrigin&) const = default;
};

/// What is connected to an output channel.
struct GuardedChannel {
  DriveGuard::Kind kind = DriveGuard::Kind::Drive;
  DriveLimits limits = {};
  FeedbackPath feedback = {};             ///< through which the output may return to itself
  std::vector<LimitOrigin> origins = {};  ///< of `limits`, as far as they are known
};

/// Why drives faded out. They come back only when the user arms them again, but for DeadMan.
struct GuardEvent {
  enum class Kind : std::uint8_t {
    Feedback,         ///< `channel`: the output that returned to itself and grew
    SensorRailed,     ///< `channel`: the input; all drives fade out
    SensorStuck,      ///< the same
    DeadMan,          ///< the dead man's switch is 500 ms old: every output fades out until it is refreshed
    DeadManDisarmed,  ///< it is 5 s old: the drives are disarmed
  };
  std::int64_t frame = 0;
  Kind kind = Kind::Feedback;
  int channel = 0;

  bool operator==(const GuardEvent&) const = default;
};

/// Observes every processed block, for a take or a meter, and before it the entries that the guard applied in
/// it. A tap that forwards blocks forwards both.
class BlockTap : public JournalTap {
 public:
  /// [realtime & prepared] What came in and what goes out behind the guard; its first frame since `prepare`.
  virtual void observe(const BlockIo& io, std::int64_t first_frame) noexcept TACTUS_NONBLOCKING = 0;
};

/// A state that any thread sets and the audio thread takes over at its next block: the last setting counts,
/// and none can be lost or delayed.
class GuardSwitch {
 public:
  /// [any]
  void set(bool on) noexcept { wanted_.store(on ? kOn : kOff, std::memory_order_release); }
  /// [realtime] The last setting since this was called before, if there was one.
  std::optional<bool> take() noexcept {
    if (wanted_.load(std::memory_order_relaxed) == kNone) return std::nullopt;
    return wanted_.exchange(kNone, std::memory_order_acquire) == kOn;
  }

 private:
  enum Wanted { kNone, kOff, kOn };
  std::atomic<Wanted> wanted_{kNone};
};

/// What backends play, and nothing else, so that nothing reaches an actuator unguarded: a Guarded, or those
/// of its channels that one of two devices has (backends/beside).
class GuardedBlocks : public BlockProcessor {
 public:
  /// [realtime & prepared] The blocks before a stop: every output comes to zero, at once or as fast as its
  /// slew limit allows. The processor inside does not run and time does not advance. True: all are at zero,
  /// and this was the last block; if `process` is called again, every guard starts softly.
  virtual bool finish(const BlockIo& io) noexcept TACTUS_NONBLOCKING = 0;
  /// [realtime & prepared] Before `process`: no block came for so long. Where the dead man's switch was not
  /// refreshed meanwhile either, as in a program that was stopped, and this is five seconds or more, the
  /// drives are disarmed.
  virtual void note_pause(Seconds pause) noexcept = 0;
  /// [realtime & prepared] Before `process`: up to so many frames were lost, and something else was played.
  virtual void note_gap(std::int64_t frames) noexcept = 0;
  /// [any] The longest time that fading out takes, of all channels.
  virtual Seconds closing_time() const noexcept = 0;
  /// [control & stopped] Frames do not run at their rate: the dead man's switch has no meaning.
  virtual void disable_dead_mans_switch() noexcept = 0;

 private:
  GuardedBlocks() = default;
  friend class Guarded;
  friend class GuardedPart;
};

/// Any BlockProcessor with the drive guard behind every output channel and a watch at every input. It also
/// turns denormals off around `process`: processors inside need not.
///
/// An output is open while it is armed, not muted and not faded. A drive is armed and disarmed by the user;
/// an audio output is armed from the start, and only feedback or an entry that names it disarms it. A user
/// mutes; `fade` is for the program, which stops. Where the dead man's switch is not refreshed, everything is
/// faded as well.
class Guarded final : public GuardedBlocks {
 public:
  /// [control] `inner` must outlive this. Channels beyond the list are drives with the conservative limits.
  Guarded(BlockProcessor& inner, std::vector<GuardedChannel> channels, bool armed = true);

  /// [control & stopped] Prepares `inner` and starts again at frame 0, with every guard closed and its soft
  /// start ahead of it. Thermal state, the time that DC has lasted and which sensors were noisy are kept: the
  /// length of the pause is unknown. Feedback paths are kept. What was muted or not armed stays so, orders
  /// for now that still waited hold from frame 0, and entries for a frame are dropped. Errors: of `inner`;
  /// BadArgument for more guards than outputs; OutOfRange for a limit.
  [[nodiscard]] Status prepare(const StreamFormat& format) override;
  /// [realtime & prepared]
  void process(const BlockIo& io) noexcept TACTUS_NONBLOCKING override;
  /// [control & stopped] Drives that sound at frame 0 do so without a soft start. For files and simulated
  /// worlds alone, where nothing is there to be thrown.
  void skip_soft_start() noexcept;
  bool finish(const BlockIo& io) noexcept TACTUS_NONBLOCKING override;

  /// [control & stopped] From the next `prepare` on, the actuators are those of a device: what they did
  /// before is unknown, so the first time they are taken to be as warm as they may stay, and each time their
  /// masses may be anywhere within their limits. Without it they start cold and at rest, as in files and
  /// simulations.
  void suppose_worst() noexcept { on_device_ = true; }

  void note_pause(Seconds pause) noexcept override;
  void note_gap(std::int64_t frames) noexcept override;

  /// [control & stopped] The sensors are recordings, which may hold silence: none is ever found at fault.
  void disable_sensor_watch() noexcept { watch_sensors_ = false; }
  /// [control & stopped] The same for the inputs that are true.
  void disable_sensor_watch(std::vector<bool> inputs) { unwatched_ = std::move(inputs); }
  /// [control & stopped] From the next `prepare` on the outputs depend on it. It outlives this; nullptr:
  /// none, for files and simulations.
  void set_dead_mans_switch(const DeadMansSwitch* dead_man) noexcept { dead_man_ = dead_man; }
  void disable_dead_mans_switch() noexcept override { dead_man_ = nullptr; }
  /// [control & stopped] `tap` outlives this, or is taken away with nullptr.
  void set_tap(BlockTap* tap) noexcept { tap_ = tap; }
  /// [any] For all channels from the next block on, whatever waits in a queue, and journalled with its frame.
  void arm(bool on) noexcept { arm_.set(on); }
  void mute(bool on) noexcept { mute_.set(on); }
  void fade(bool on) noexcept { fade_.set(on); }
  /// [control & prepared] From the next block on outputs may return to themselves in these ways too, by
  /// channel, whatever waits in a queue, and journalled with its frame: before an edit takes over.
  void add_feedback_paths(const std::vector<FeedbackPath>& paths) noexcept;
  /// [control, one thread] Kinds Arm, Mute, Fade, DeadMan, CoilHeat, BodyHeat, DcTime, SensorNoise,
  /// FeedbackPath and Displacement, in frame order; a late entry is applied at once, and one for kNow before
  /// all that wait for their frame. A heat can only make warmer, a DC time only longer, and a feedback path
  /// is only added. False: the queue is full, try again after a block; or it is another kind.
  [[nodiscard]] bool post(const JournalEntry& entry) noexcept;
  /// [control, one thread] What made drives fade out, oldest first. False: nothing new.
  [[nodiscard]] bool take_event(GuardEvent& event) noexcept { return events_.pop(event); }

  /// [any] What it was made with.
  const std::vector<GuardedChannel>& channels() const noexcept { return config_; }
  bool armed_at_start() const noexcept { return armed_at_start_; }
  Seconds closing_time() const noexcept override;
  /// [any] Every output ended the last block closed and at zero.
  bool silent() const noexcept { return silent_.load(std::memory_order_relaxed); }
  /// [control & stopped] What brings a new Guarded of the same channels to the state of this one, as entries
  /// for frame 0: all that differs from a fresh one.
  std::vector<JournalEntry> state() const;

  /// [any]
  GuardCounts counts(int channel) const noexcept { return channels_[index(channel)].guard.counts(); }
  /// [any] Keep it and post it again as CoilHeat and BodyHeat of frame 0.
  ThermalState thermal_state(int channel) const noexcept {
    return channels_[index(channel)].guard.thermal_state();
  }
  /// [any] How far the mass may be from rest, as a share of its limit, 64 frames ago at most; 0 without one.
  double excursion(int channel) const noexcept { return channels_[index(channel)].guard.excursion(); }
  /// [any] Frames processed since `prepare`.
  std::int64_t frame() const noexcept { return frame_.load(std::memory_order_relaxed); }

 private:
  struct Channel {
    Channel(const GuardedChannel& with, Hertz sample_rate, bool is_armed)
        : guard(with.kind, with.limits, sample_rate, with.feedback), armed(is_armed || !is_drive()) {}
    bool is_drive() const { return guard.kind() == DriveGuard::Kind::Drive; }
    bool is_enabled() const { return !muted && armed; }

    DriveGuard guard;
    bool armed, muted = false;
    std::atomic<int> new_paths{0};  ///< FeedbackPath::bits that wait for the audio thread
  };

  void observe_dead_man(std::int64_t frame) noexcept;
  void act_on_dead_man(DeadMansWatch::Action action, std::int64_t frame) noexcept;
  bool at_rest(std::int64_t frame) const noexcept;
  void guard_block(const BlockIo& io, std::int64_t first_frame) noexcept;
  void guard_frames(const BlockIo& io, int from, int to, std::int64_t first_frame) noexcept;
  void guard_outputs(const BlockIo& io, int from, int to, std::int64_t first_frame) noexcept;
  int first_sensor_fault(const BlockIo& io, int from, int to, std::int64_t first_frame) noexcept;
  template <class Apply>
  void take_pending(Apply apply) noexcept;
  template <class Apply>
  void take_new_paths(Apply apply) noexcept;
  void apply(JournalEntry entry, std::int64_t frame) noexcept;
  bool apply_command(const JournalEntry& command) noexcept;
  static void apply_to(Channel& channel, const JournalEntry& command) noexcept;
  GuardedChannel config_of(int channel) const;
  void restore(const Channel& before, Channel& channel) noexcept;
  void open_guards(std::int64_t frame) noexcept;

  BlockProcessor& inner_;
  std::vector<GuardedChannel> config_;
  bool armed_at_start_;
  bool stopped_ = false, faded_ = false;
  bool expired_ = false;  ///< the dead man's switch
  const DeadMansSwitch* dead_man_ = nullptr;
  DeadMansWatch dead_mans_watch_;
  bool watch_sensors_ = true;
  std::vector<bool> unwatched_;  ///< of each input
  bool on_device_ = false;
  BlockTap* tap_ = nullptr;
  std::deque<Channel> channels_;
  std::vector<SensorWatch> sensors_;
  std::atomic<std::int64_t> frame_{0};
  std::atomic<bool> silent_{false};
  GuardSwitch arm_, mute_, fade_;
  std::atomic<bool> has_new_paths_{false};
  ControlInbox inbox_;
  SpscQueue<JournalEntry> at_once_{256};
  SpscQueue<GuardEvent> events_{64};
};

}  // namespace tactus
