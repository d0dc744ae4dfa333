#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <vector>

#include "engine/core/block_io.h"
#include "engine/core/journal.h"
#include "engine/core/spsc_queue.h"
#include "engine/guard/drive_guard.h"
#include "engine/guard/sensor_watch.h"

namespace tactus {

/// What stands behind an output channel.
struct GuardedChannel {
  DriveGuard::Kind kind = DriveGuard::Kind::Drive;
  DriveLimits limits;
};

/// Something that made drives fade out. They come back only when the user arms them again.
struct GuardEvent {
  enum class Kind : std::uint8_t {
    Howl,          ///< `channel`: the output that was held back for more than half of 200 ms
    SensorRailed,  ///< `channel`: the input; all drives fade out
    SensorStuck,   ///< the same
  };
  std::int64_t frame = 0;
  Kind kind = Kind::Howl;
  int channel = 0;

  bool operator==(const GuardEvent&) const = default;
};

/// Hears every block as it went by, for a take or a meter, and before it what the guard applied in it. A tap
/// that hands on blocks hands on both.
class BlockTap : public JournalTap {
 public:
  /// [realtime & prepared] What came in and what goes out behind the guard; its first frame since `prepare`.
  virtual void hear(const BlockIo& io, std::int64_t first_frame) noexcept TACTUS_NONBLOCKING = 0;
};

/// Any BlockProcessor with the drive guard behind every output channel and a watch at every input. Backends
/// accept nothing else, so nothing reaches an actuator unguarded. It also turns denormals off around
/// `process`, and cuts a block that is longer than promised, so that the processor inside never sees one.
///
/// A drive sounds while it is armed and not muted, an audio output while it is not muted.
class Guarded final : public BlockProcessor {
 public:
  /// [control] `inner` must outlive this. Channels beyond the list are drives with the cautious limits.
  Guarded(BlockProcessor& inner, std::vector<GuardedChannel> channels, bool armed = true);
  ~Guarded() override;

  /// [control & stopped] Prepares `inner` and starts again at frame 0, with every guard closed and its soft
  /// start ahead of it. What was warm is as warm as it was: nobody knows how long the pause lasted. What was
  /// muted or not armed stays so, orders for now that still waited hold from frame 0, and entries for a frame
  /// are dropped. Errors: of `inner`; BadArgument for more guards than outputs; OutOfRange for a limit.
  [[nodiscard]] Status prepare(const StreamFormat& format) override;
  /// [realtime & prepared]
  void process(const BlockIo& io) noexcept TACTUS_NONBLOCKING override;
  /// [control & stopped] Drives that sound at frame 0 do so without a soft start. For files and simulated
  /// worlds alone, where nothing is there to be thrown.
  void skip_soft_start() noexcept;
  /// [realtime & prepared] The last block before a stop: zeros on every output. The processor inside does not
  /// run and time stands still; if `process` is called again, every guard starts softly.
  void finish(const BlockIo& io) noexcept TACTUS_NONBLOCKING;

  /// [control & stopped] The sensors are recordings, which may hold silence: none is ever found at fault.
  void trust_sensors() noexcept { trusting_ = true; }
  /// [control & stopped] `tap` outlives this, or is taken away with nullptr.
  void set_tap(BlockTap* tap) noexcept { tap_ = tap; }
  /// [control, one thread] Kinds Arm, Mute, CoilHeat and BodyHeat, in frame order; an entry that comes late
  /// holds at once, and one for kNow overtakes all that wait for their frame. A heat can only make warmer.
  /// False: the queue is full, try again after a block; or it is another kind.
  [[nodiscard]] bool post(const JournalEntry& entry) noexcept;
  /// [control, one thread] What was applied, with its true frame, oldest first. False: nothing new.
  [[nodiscard]] bool take_applied(JournalEntry& entry) noexcept { return applied_.pop(entry); }
  /// [control, one thread] What made drives fade out, oldest first. False: nothing new.
  [[nodiscard]] bool take_event(GuardEvent& event) noexcept { return events_.pop(event); }

  /// [any] What it was made with.
  const std::vector<GuardedChannel>& channels() const noexcept { return config_; }
  bool armed_at_start() const noexcept { return armed_at_start_; }
  /// [control & stopped] What brings a new Guarded of the same channels to the state of this one, as entries
  /// for frame 0: arms, mutes and heats that are not those of a fresh one.
  std::vector<JournalEntry> state() const;

  /// [any] As of the last whole block.
  GuardCounts counts(int channel) const noexcept;
  /// [any] As of the last whole block. Keep it and post it again as CoilHeat and BodyHeat of frame 0.
  ThermalState thermal_state(int channel) const noexcept;
  /// [any] Frames processed since `prepare`.
  std::int64_t frame() const noexcept { return frame_.load(std::memory_order_relaxed); }

 private:
  struct Channel;

  void process_piece(const BlockIo& io, int offset, int frames) noexcept;
  void guard_frames(int from, int to, std::int64_t first_frame) noexcept;
  void guard_outputs(int from, int to, std::int64_t first_frame) noexcept;
  int first_sensor_fault(int from, int to, std::int64_t first_frame) noexcept;
  void apply(JournalEntry entry, std::int64_t frame) noexcept;
  void tell(const JournalEntry& entry) noexcept;
  bool obey(const JournalEntry& order) noexcept;
  void disarm_drives(std::int64_t frame) noexcept;
  void open_guards(std::int64_t frame) noexcept;

  BlockProcessor& inner_;
  std::vector<GuardedChannel> config_;
  bool armed_at_start_;
  bool stopped_ = false;
  bool trusting_ = false;
  BlockTap* tap_ = nullptr;
  StreamFormat format_;
  std::vector<Channel> channels_;
  std::vector<SensorWatch> sensors_;
  std::vector<const double*> in_;  // the piece in hand
  std::vector<double*> out_;
  std::atomic<std::int64_t> frame_{0};
  SpscQueue<JournalEntry> inbox_{256};
  SpscQueue<JournalEntry> at_once_{256};
  SpscQueue<JournalEntry> applied_{1024};
  SpscQueue<GuardEvent> events_{64};
};

}  // namespace tactus
