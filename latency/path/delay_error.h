#pragma once
// Thread: [control]

#include <vector>

#include "latency/path/path_model.h"

namespace tactus {

/// One of the repeated bursts, cut out like the mean that the path was fitted to.
struct RepeatedWindow {
  Spectrum captured;    ///< as of a burst of gain 1
  double weight = 0.0;  ///< in the mean; together 1
};

/// By how much a fitted delay may be wrong, from how the repeated bursts differ: whatever the noise is, it
/// differs from one to the next.
struct DelayError {
  /// Standard error. What a burst adds to the delay in a quarter of an octave is taken as independent of what
  /// it adds in the others, and of other bursts ("cluster-robust"; weights as HC2 in J. MacKinnon, H. White,
  /// "Some heteroskedasticity-consistent covariance matrix estimators", J. Econometrics 29, 1985). Where
  /// whole bursts move, their scatter counts.
  double noise_frames = 0.0;
  /// What the path's shape may do: the rms of the phase that the model leaves, beyond that noise, over the
  /// rms frequency; and the delay of whatever makes its gain fall with the frequency.
  double shape_frames = 0.0;

  /// [control] Of at least two.
  static DelayError of(const CapturedWindow& mean, const PathFit& fit,
                       const std::vector<RepeatedWindow>& bursts);
};

}  // namespace tactus
