#pragma once
// Thread: [control, one thread]

#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "engine/core/journal.h"
#include "engine/core/ramp.h"
#include "engine/core/units.h"
#include "remote/remote.h"
#include "remote/stream_clock.h"

namespace tactus {

/// A control as a schedule moves it, in SI.
struct ScheduledControl {
  double value = 0.0;  ///< that it was set to last
  double low = 0.0, high = 0.0;
  double smooth_s = 0.0;  ///< its own ramp after each change
  bool decibel = false;   ///< it ramps on a straight line in decibels
};

/// Where the orders of a schedule go.
class ScheduleTarget {
 public:
  virtual ~ScheduleTarget() = default;
  /// Nothing: there is no such control, or it cannot be changed.
  virtual std::optional<ScheduledControl> control(int number) const = 0;
  /// The control is about to have this value.
  virtual void note(int number, double value) = 0;
  virtual void gesture(int number, double value) = 0;
  /// False: there is no room; try again later.
  virtual bool post(const JournalEntry& entry) = 0;
};

/// Turns bundles of orders into journal entries, each for its frame, and posts them shortly before it: the
/// queue of a player applies entries in the order in which they were posted, so that one for a late frame
/// holds up those behind it. All orders of a bundle apply from the same frame on. A ramp of T seconds is a
/// straight line (in decibels where the control is), made of changes that are as far apart as the control's
/// own ramp takes, or 2 ms where it has none or a shorter one. Another change of the control ends a ramp.
class RemoteSchedule {
 public:
  /// How long before its frame a bundle with a time tag is posted, and a point of a ramp.
  static constexpr Seconds kAhead{0.020}, kRampAhead{0.005};
  static constexpr std::size_t kMostWaiting = 4096;  ///< orders

  RemoteSchedule(Hertz sample_rate, ScheduleTarget& target) : rate_(sample_rate.value), target_(target) {}

  /// False: too many wait.
  bool add(std::span<const RemoteOrder> bundle);
  /// A change by somebody else ends the ramp of a control.
  void end_ramp(int number) { ramps_.erase(number); }
  /// Frames are counted from 0 again: what was made for a frame is dropped. Bundles wait on.
  void restart();
  /// `frame`: that the player has reached; `first_free`: the first one that it cannot have begun with.
  void advance(const StreamClock& clock, std::int64_t frame, std::int64_t first_free);

  /// Bundles with a time tag that came too late for it, so far.
  std::int64_t late() const { return late_; }
  /// The last frame that has an entry of this.
  std::int64_t last_frame() const { return last_; }

 private:
  struct MovingControl {
    double from = 0.0, to = 0.0;
    bool decibel = false;
    std::int64_t start = 0, step = 1;  ///< frames
    std::int64_t points = 1, next = 0;
    double last_value = 0.0;  ///< that it was set to

    double value_at(std::int64_t point) const;
  };
  using Bundle = std::vector<RemoteOrder>;

  std::optional<std::int64_t> frame_of(const Bundle& bundle, const StreamClock& clock,
                                       std::int64_t first_free);
  void apply(const RemoteOrder& order, std::int64_t frame);
  void begin_ramp(const RemoteOrder& order, const ScheduledControl& control, std::int64_t frame);
  void change(int number, double value, std::int64_t frame);
  void pulse(int number, const ScheduledControl& control, std::int64_t frame);
  void advance_ramps(std::int64_t until, std::int64_t first_free);
  bool advance(int number, MovingControl& ramp, std::int64_t until, std::int64_t first_free);
  void emit(const JournalEntry& entry);
  void post(std::int64_t first_free);

  double rate_;
  ScheduleTarget& target_;
  std::multimap<double, Bundle> waiting_;  ///< by time; RemoteOrder::kNow comes first
  std::size_t orders_ = 0;                 ///< in `waiting_`
  std::map<int, MovingControl> ramps_;     ///< by control
  std::map<int, std::int64_t> free_;       ///< first frame in which a trigger can rise again
  std::deque<JournalEntry> outgoing_;      ///< by frame
  std::int64_t last_ = 0, late_ = 0;
};

}  // namespace tactus
