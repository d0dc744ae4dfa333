#pragma once

// Thread: [control]

#include <vector>

#include "engine/core/units.h"

namespace tactus {

/// Frames at which a trigger signal rises through 0.5.
std::vector<double> trigger_times(const std::vector<double>& samples, Hertz sample_rate);

/// One strike, from the first contact to the last, short gaps included.
struct Strike {
  double start_s, end_s;
  double peak;  ///< largest force
};

/// Strikes in a contact force: pushes less than `gap` apart are one; those with a peak below `least` do not
/// count.
std::vector<Strike> find_strikes(const std::vector<double>& force, Hertz sample_rate, Seconds gap,
                                 double least);

/// The rhythm of event times; zeros where there are too few.
struct Rhythm {
  int count = 0;
  double last_s = 0;
  double rate_hz = 0;          ///< (count - 1) / (last - first)
  int fewest_in_a_second = 0;  ///< over windows of 1 s, from `from` to `to`
  double spread = 0;           ///< standard deviation of the intervals / their mean
  double long_short = 0;       ///< median over neighbouring intervals of the longer / the shorter
  int growing = 0;             ///< longest run of intervals, each at least 3 % longer than the one before it
};
Rhythm rhythm_of(const std::vector<double>& times_s, double from_s, double to_s);

/// Speed of `position` just after each strike over the speed just before, as slopes over 1 ms; the geometric
/// mean, which is what one strike leaves on average: 1 in a roll that neither grows nor dies.
double restitution(const std::vector<double>& position, Hertz sample_rate,
                   const std::vector<Strike>& strikes);

/// Events in the second from a time on; times rise.
int events_in_second(const std::vector<double>& times_s, double from_s);

/// How well a detector did.
struct Detection {
  int found = 0, missed = 0, doubled = 0;
  double latest_s = 0;               ///< longest time from the start of a touch to its trigger
  std::vector<double> found_s = {};  ///< times of the triggers that have a touch
};
/// `touches` in order, as find_strikes gives them with a small gap and a low least force. A trigger belongs
/// to the last touch before it, if that began at most 6 ms ago and has none yet; otherwise it is doubled. A
/// touch of at least `least` is missed if it has no trigger, unless another one was detected less than 15 ms
/// before it: then the two count as one.
Detection match(const std::vector<Strike>& touches, const std::vector<double>& triggers_s, double least);
/// A touch may be detected so late.
inline constexpr Seconds kDetectionDelay = 6_ms;

}  // namespace tactus
