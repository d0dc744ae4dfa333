#pragma once

#include <vector>

#include "engine/core/units.h"

namespace tactus {

/// Frames at which a trigger signal rises through 0.5.
std::vector<double> trigger_times(const std::vector<double>& samples, Hertz sample_rate);

/// One touch of a stick: from the first push to the last, short gaps included.
struct Strike {
  double start_s, end_s;
  double peak;  ///< largest force
};

/// Strikes in a contact force: pushes less than `gap` apart are one; those with a peak below `least` do not
/// count.
std::vector<Strike> find_strikes(const std::vector<double>& force, Hertz sample_rate, Seconds gap,
                                 double least);

/// What the times of events say about rhythm; zeros where there are too few.
struct Rhythm {
  int count = 0;
  double first_s = 0, last_s = 0;
  double rate_hz = 0;          ///< (count - 1) / (last - first)
  int fewest_in_a_second = 0;  ///< over windows of 1 s, from `from` to `to`
  double spread = 0;           ///< standard deviation of the intervals / their mean
  double long_short = 0;       ///< median over neighbouring intervals of the longer / the shorter
  int growing = 0;             ///< longest run of intervals, each at least 3 % longer than the one before it
};
Rhythm rhythm_of(const std::vector<double>& times_s, double from_s, double to_s);

/// Speed of `position` just after each strike over the speed just before, as slopes over 1 ms; the median.
double restitution(const std::vector<double>& position, Hertz sample_rate,
                   const std::vector<Strike>& strikes);

/// How well a detector did: found, missed and false or doubled. A trigger belongs to a strike if it comes
/// from the strike's start to `late` after it.
struct Detection {
  int found = 0, missed = 0, doubled = 0;
  double latest_s = 0;  ///< longest time from the start of a strike to its trigger
};
Detection match(const std::vector<Strike>& strikes, const std::vector<double>& triggers_s, Seconds late);

}  // namespace tactus
