#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "latency/estimation/analysis.h"

namespace tactus {

/// A delay at one time.
struct DelayPoint {
  std::int64_t played_at = 0;
  double delay_frames = 0.0;
};

/// A straight line through delays, and where they jump off it: from the median since the last jump, so that a
/// jump in the middle of a probe, which moves it by half, is none the less one. Between jumps it is least
/// squares with one slope for all segments; before that the slope is the median of those between neighbours,
/// which a jump does not move.
struct DelayTrend {
  double slope = 0.0;            ///< frames per frame
  double slope_deviation = 0.0;  ///< from the scatter around the line; 0 for fewer than three points
  std::vector<DelayStep> steps;
  std::vector<std::size_t> longest;  ///< points of the segment without a step that has most of them
  double scatter = 0.0;              ///< standard deviation around the line in that segment

  /// [control] A jump is more than `least_step` frames off the line.
  static DelayTrend of(std::span<const DelayPoint> points, double least_step);
};

/// [control] What a recording would have been at another speed:  out[n] = in(n * speed), by a sum over the 64
/// nearest samples with a Kaiser-windowed sinc: right within −90 dB up to 0.42 of the sample rate.
std::vector<double> at_speed(std::span<const double> samples, double speed);

}  // namespace tactus
