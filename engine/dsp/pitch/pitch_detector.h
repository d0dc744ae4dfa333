#pragma once

// Thread: [control].

#include <cmath>
#include <span>
#include <vector>

#include "engine/core/units.h"

namespace tactus {

/// [any] How far one pitch lies above another.
inline double cents(double hertz, double of) { return 1200 * std::log2(hertz / of); }

/// Between two moments of a track.
inline constexpr double kPitchHop_s = 0.010;

/// What sounds around one moment.
struct PitchPoint {
  double time_s = 0;
  double hertz = 0;    ///< how often a second it repeats itself
  double clarity = 0;  ///< 1: it repeats itself exactly
  int partial = 1;     ///< the strongest of its first twelve
  double rms = 0;
};

/// Pitch of a signal every kPitchHop_s, wherever it repeats itself with a period between 1/hi and 1/lo.
/// Moments without a pitch are left out: silence (below -120 dBFS, or 60 dB below the loudest), noise, and
/// the first and last three periods.
///
///   coarse   n(t) = 2 sum x[j] x[j+t] / sum (x[j]^2 + x[j+t]^2), the first peak above 0.9 of the highest
///   fine     the phases of the partials turn by 2 pi h f d from a window to one d later; both are four
///   periods
///            long (Hann: whole partials do not reach into one another). f by least squares, weighted by
///            power
///
/// Of a steady tone the error is below 0.1 cent. `clarity` is n at its peak; below 0.8 nothing counts.
/// Source: McLeod & Wyvill, ICMC 2005 (coarse); phase difference: Flanagan & Golden, BSTJ 45, 1966.
/// [control]
std::vector<PitchPoint> track_pitch(std::span<const double> samples, Hertz rate, Hertz lo, Hertz hi);

}  // namespace tactus
