#pragma once

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include "engine/core/realtime.h"
#include "engine/core/spsc_queue.h"

namespace tactus {

/// An input of `process` that is no sample. Samples and journal together determine the output: a take that
/// keeps both replays bit for bit, whatever the block size.
struct JournalEntry {
  enum class Kind : std::uint8_t {
    ControlChange,  ///< `index`: control; `value`: its new target, SI
    Arm,            ///< `index`: output channel or kAllChannels; `value`: 1 lets the drive move, 0 does not
    Mute,           ///< `index`: output channel or kAllChannels; `value`: 1 silences, 0 releases
    SystemDelay,    ///< `value`: sensor voltage to actuator voltage [frames]; negative: unknown from now on,
                    ///< the last one is kept
    LostFrames,     ///< `value`: frames that went missing just before `frame`
    CoilHeat,       ///< `index`: output channel; `value`: lower bound of the coil's heat (ThermalState)
    BodyHeat,       ///< the same for the actuator's body
    Replacement,    ///< another version of the graph took over; `index`: how many there were so far
    Halt,           ///< the stream was stopped just before `frame`, with zeros, and went on without `prepare`
    Fade,           ///< `index`: kAllChannels; `value`: 1 fades every output out, 0 lets it come back
    ControlSet,     ///< as ControlChange, but at once, without the control's ramp
    DeadMan,        ///< `index`: kAllChannels; `value`: 1: the dead man's switch expired, every output fades
                    ///< out; 0: it is refreshed again
    DcTime,         ///< `index`: output channel; `value`: lower bound of the time that DC has lasted [s]
    SensorNoise,    ///< `index`: input channel, on which noise was observed
    FeedbackPath,   ///< `index`: output channel; `value`: 1 an input leads there, 2 a loop of the graph, 3
                    ///< both
    Displacement,   ///< `index`: output channel; `value`: the mass may be as far from rest as this share of
                    ///< its limit, and moving
  };

  static constexpr int kAllChannels = -1;
  /// For an entry that applies as soon as it arrives. Applied entries carry the true frame.
  static constexpr std::int64_t kNow = -1;

  std::int64_t frame = kNow;  ///< first frame that it applies to, counted since `prepare`
  Kind kind = Kind::ControlChange;
  int index = 0;
  double value = 0.0;

  bool operator==(const JournalEntry&) const = default;
};

/// Receives every entry when it is applied.
class JournalTap {
 public:
  virtual ~JournalTap() = default;
  /// [realtime] `entry` carries its true frame, which lies in the block being processed.
  virtual void applied(const JournalEntry& entry) noexcept TACTUS_NONBLOCKING = 0;
};

/// [control] What enters `process` besides samples, each entry applied at its frame: a journal known
/// beforehand, and entries posted while it runs.
class ControlInbox {
 public:
  /// [control & stopped] Sorted by frame; applies from the next `take_due` on.
  void set_journal(std::vector<JournalEntry> entries) {
    journal_ = std::move(entries);
    next_ = journal_.data();
  }
  /// [control & stopped] Frames are counted from 0 again: the journal starts again, posted entries for now
  /// stay, and those for a frame, which was counted from the former start, are dropped.
  void restart() {
    next_ = journal_.data();
    std::vector<JournalEntry> stay;
    for (JournalEntry entry; posted_.pop(entry);)
      if (entry.frame == JournalEntry::kNow) stay.push_back(entry);
    for (const auto& entry : stay) (void)posted_.push(entry);
  }
  /// [control & stopped] `tap` observes every entry that is applied, with its true frame. nullptr: none.
  void set_tap(JournalTap* tap) noexcept { tap_ = tap; }
  /// [control, one thread] False: the queue is full.
  [[nodiscard]] bool post(const JournalEntry& entry) noexcept { return posted_.push(entry); }

  /// [control & stopped] Drops the entries that wait for their frame.
  void drop_posted() noexcept {
    while (posted_.front() != nullptr) posted_.drop_front();
  }

  /// [realtime] No entry is due or will be.
  bool empty() noexcept { return next_ == end() && posted_.front() == nullptr; }
  /// [realtime] Gives every entry that is due at `now` to `apply`. Returns the frames until the next one, at
  /// most `frames`.
  template <class Apply>
  std::int64_t take_due(std::int64_t now, std::int64_t frames, Apply apply) noexcept {
    for (; next_ != end() && next_->frame <= now; ++next_) take(*next_, now, apply);
    if (next_ != end()) frames = std::min(frames, next_->frame - now);
    const JournalEntry* posted = posted_.front();
    for (; posted != nullptr && posted->frame <= now; posted = posted_.front()) {
      take(*posted, now, apply);
      posted_.drop_front();
    }
    return posted == nullptr ? frames : std::min(frames, posted->frame - now);
  }
  /// [realtime] Shows an entry to the tap.
  void observe(const JournalEntry& entry) noexcept {
    if (tap_ != nullptr) tap_->applied(entry);
  }

 private:
  template <class Apply>
  void take(const JournalEntry& entry, std::int64_t now, Apply apply) noexcept {
    observe({now, entry.kind, entry.index, entry.value});
    apply(entry);
  }

  const JournalEntry* end() const noexcept { return journal_.data() + journal_.size(); }

  std::vector<JournalEntry> journal_;
  const JournalEntry* next_ = journal_.data();
  SpscQueue<JournalEntry> posted_{256};
  JournalTap* tap_ = nullptr;
};

}  // namespace tactus
