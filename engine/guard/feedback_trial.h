#pragma once
// Thread: [realtime] unless stated otherwise

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "engine/core/units.h"
#include "engine/guard/guard_group.h"

namespace tactus {

/// Silences a drive that has been limited for long, and observes what it is then asked to do. Through a loop
/// the wanted signal falls because the output is silent, and stays low as long as it is; it comes back when
/// the drive is let through again.
///
///   level    half of what the wanted signal swings over the last 0.13 s, every 11 ms: a mass that a silent
///            drive no longer holds stops somewhere else, far from zero perhaps
///   falling  the drive is silent until the level has fallen by 4.4 dB
///   silent   it stays silent for 0.32 s and twice the time of the fall
///   playing  it is let through, until it has been limited again for 0.19 s and 1.5 times the time of the
///            fall, and swings: longer than it was limited before and took to fall, so no rhythm falls with
///            both silences
///   loop     it fell twice, in times that are equal within a step and an eighth, or three times, the last
///            two in times that agree within a factor of 2; or it fell in two trials
///   outside  after 0.21 s of silence or more the level is above 95 % of the highest since, and one of the
///            last two steps swings as before (by 30 %), or the level has not fallen after 0.5 s, or it rises
///            again during the silence or is not below 55 % after it, or it falls by 6 dB while the drive
///            plays, or the drive is not limited again within 10 s and 30 times the time of the fall, nor
///            does the level still rise by a tenth each second
class FeedbackTrial {
 public:
  enum class Verdict { None, Feedback, Outside };

  /// [control]
  explicit FeedbackTrial(Hertz sample_rate)
      : groups_(std::max(1, static_cast<int>(std::lround(kStep_s * sample_rate.value / kGuardGroup)))) {}

  bool active() const noexcept { return state_ != State::Idle; }
  bool is_muted() const noexcept { return state_ == State::Falling || state_ == State::Silent; }
  /// It is much louder than when the last trial ended: perhaps a loop that was not loud enough to be noticed
  /// then.
  bool is_louder() const noexcept { return level() > kLouder * reference_; }
  void begin() noexcept;
  void forget() noexcept { *this = FeedbackTrial{groups_}; }
  /// A frame that did not pass as it was: what was wanted.
  void observe(double wanted) noexcept { now_.add({wanted, wanted}); }
  /// A group is over; `limited`: the drive is being limited.
  Verdict end_group(bool limited) noexcept;

 private:
  enum class State { Idle, Falling, Silent, Playing };
  struct Range {
    double low = std::numeric_limits<double>::infinity(), high = -low;
    void add(const Range& other) noexcept {
      low = std::min(low, other.low);
      high = std::max(high, other.high);
    }
    double half() const noexcept { return std::max(0.0, (high - low) / 2.0); }
  };
  static constexpr double kStep_s = 0.0107;
  static constexpr double kLouder = 3.0;

  explicit FeedbackTrial(int groups) : groups_(groups) {}
  double level() const noexcept {
    Range all = now_;
    for (const auto& range : ranges_) all.add(range);
    return all.half();
  }
  /// Of a step, in the mean over the level's.
  double swing() const noexcept {
    double sum = 0.0;
    for (const auto& range : ranges_) sum += range.half();
    return sum / static_cast<double>(ranges_.size());
  }
  double last_swing() const noexcept { return std::max(ranges_.back().half(), (ranges_.end() - 2)->half()); }
  Verdict step(double level, bool limited) noexcept;
  Verdict falling(double level) noexcept;
  Verdict silent(double level) noexcept;
  Verdict playing(double level, bool limited) noexcept;
  void mute() noexcept;
  bool waits_on(double level) noexcept;
  Verdict outside() noexcept;
  Verdict judge() noexcept;
  void go(State state) noexcept { state_ = state, steps_ = 0; }

  int groups_;  ///< of a step
  State state_ = State::Idle;
  int group_ = 0, steps_ = 0, wait_ = 0, disagreements_ = 0;
  int falls_ = 0, last_fall_ = 0, fall_ = 0;  ///< how many; of the one before and of this one, in steps
  bool limited_again_ = false, rises_ = false;
  double risen_ = 0.0;                    ///< the level a second ago
  double reference_ = 0.0, swing_ = 0.0;  ///< level and swing before the silence
  double highest_ = 0.0, lowest_ = 0.0;
  Range now_;                       ///< of this step
  std::array<Range, 12> ranges_{};  ///< of the last steps
};

}  // namespace tactus
