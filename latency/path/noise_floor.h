#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "engine/core/units.h"

namespace tactus {

/// What is captured while nothing is played.
struct NoiseFloor {
  double mean = 0.0;              ///< DC
  double variance = 0.0;          ///< without DC
  std::vector<double> per_frame;  ///< power spectrum of one frame of it, from 0 to half the sample rate; its
                                  ///< mean is `variance`

  /// [control] By Welch's method, in windows of 1024 frames. A stretch of less than two of them has a flat
  /// spectrum.
  static NoiseFloor of(std::span<const double> quiet);
  /// [any] The power that `frames` frames of it have in each bin of a transform of `size`.
  std::vector<double> in_bins(std::size_t size, double frames) const;
};

}  // namespace tactus
