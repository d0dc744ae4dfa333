#pragma once
// Thread: [control]

#include <optional>
#include <span>
#include <vector>

#include "engine/core/units.h"

namespace tactus {

/// [control] Quantities of a sampled motion, interpolated between the samples.

/// From the first to the last swing, by its rises and its fall through the middle between the highest and the
/// lowest sample, each on the polynomial through eight samples. Its own error is below (w T)^9 / 1000 of a
/// radian in all swings. Nothing: fewer than two rises.
std::optional<double> frequency_of(std::span<const double> samples, Hertz rate);

/// a of a motion A e^-at about 0: the slope of the logarithm of its peaks, each on a parabola through three
/// samples. [1/s] Nothing: fewer than two peaks.
std::optional<double> decay_of(std::span<const double> samples, Hertz rate);

/// Of the straight line nearest to the samples. [unit/s] Nothing: fewer than two.
std::optional<double> slope_of(std::span<const double> samples, Hertz rate);

/// When the samples fall from above 0 to 0 or below, on the parabola through the three samples before: what
/// happens after a touch cannot move it. They need not be seen below: where that parabola and the one through
/// the three samples behind both reach 0 between two samples, what fell has bounced there (a motion that is
/// smooth has one parabola, and turns above 0). [s] from the first sample
std::vector<double> falls_through_zero(std::span<const double> samples, Hertz rate);

// ---- landings of a ball on a table that moves

/// One landing of a ball on a table that moves.
struct Landing {
  double time_s;   ///< of the touch, from the first sample
  double speed;    ///< towards the table just before [m/s]
  double rebound;  ///< away from the table as it was, less what the ball's own fall took meanwhile [m/s]
};

/// [control] Landings, from the positions of both [m]: where the gap falls to 0 or below, and how it was
/// until then and is once the two are apart again, as if all of the touch happened at its start. Slopes are
/// taken through three samples. A touch that has not ended is none.
std::vector<Landing> landings_of(std::span<const double> ball, std::span<const double> table, Hertz rate);

/// [any] How unlike landings are that lie `apart` landings apart, root mean square [m/s].
double split_of(const std::vector<double>& speeds, int apart);

/// Landings that differ by no more are alike, over the mean of their speeds.
inline constexpr double kAlikeLandings = 0.01;
/// A longer orbit is taken for one that never closes.
inline constexpr int kLongestOrbit = 8;
/// [any] Landings until a ball does the same again: the least p <= kLongestOrbit with
/// split_of(speeds, p) <= kAlikeLandings * mean. 0: there is none, or there are no more than 2 p landings.
int period_of(const std::vector<double>& speeds);

/// What a ball does on its table.
struct Bouncing {
  std::vector<double> speeds;      ///< of the landings, towards the table [m/s]
  int period = 0;                  ///< see `period_of`
  double landings_per_second = 0;  ///< over whole orbits, if there are
};
/// [control] Of the landings between two times, from the positions of both.
Bouncing bouncing_in(std::span<const double> ball, std::span<const double> table, Hertz rate, double from_s,
                     double to_s);

}  // namespace tactus
