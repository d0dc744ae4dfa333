#pragma once
// Thread: [control]

#include <array>
#include <complex>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "latency/estimation/fourier.h"

namespace tactus {

/// How a path answers at the angular frequency w [rad/frame]:
///
///   H(w) = gain P(w) exp(sum over k of high_pass[k] u^k + sum over k of droop[k] v^k - i w delay)
///   u = 0.01 / (i w),  v = (w / π)²
///
/// P is the path's profile, 1 for a cable. Any chain of coupling capacitors is a power series in 1 / (i w)
/// with real coefficients; well above their corners three terms are enough. `droop` is what filters without a
/// phase do.
struct PathModel {
  static constexpr double kScale = 0.01;  ///< rad/frame: 76 Hz at 48 kHz
  double delay_frames = 0.0;
  double log_gain = 0.0;
  double sign = 1.0;
  std::array<double, 5> shape{};  ///< three of high_pass, then two of droop

  /// Without P.
  std::complex<double> at(double w) const;
  /// With P where there is one (`profile` empty: none), for every bin of a transform.
  Spectrum spectrum(std::size_t size, const Spectrum& profile) const;
};

/// What was played and what was captured of it, in the same window.
struct CapturedWindow {
  std::size_t size = 0;  ///< of the transforms
  Spectrum played;       ///< the waveform, at the window's beginning
  Spectrum captured;
  std::vector<double> noise;  ///< power of what is only noise in `captured`, bin by bin
  Spectrum profile;           ///< P; empty: 1
  std::size_t lowest_bin = 1;
};

/// A fit and how good it is.
struct PathFit {
  PathModel model;
  double delay_deviation = 0.0;  ///< [frames] as the noise makes it
  double gain_deviation = 0.0;   ///< of the log gain
  /// Of shape[0], as the noise makes it. Nothing: the shape was kept.
  std::optional<double> high_pass_deviation;
  double droop = 0.0;  ///< of the log gain up to the highest bin that matters, beyond what the noise makes
  std::array<double, 7> delay_row{};  ///< of the inverse of the equations' matrix
  double chi_squared = 0.0;           ///< per bin: 1 when the model explains all but the noise
  double strength = 0.0;              ///< of the path, in standard deviations of what the model leaves over
  double misfit = 0.0;  ///< share of the captured power, weighted as the fit, that it does not explain
};

/// Which of the model's numbers are free besides delay and gain.
enum class PathShape { Kept, Free };

/// [control] Least squares over all bins from the lowest, each weighted by 1 / noise: Levenberg–Marquardt
/// from `start`, whose delay must be right to a frame. For normal noise and a path that has the model's
/// shape, this is the maximum-likelihood estimate.
PathFit fit_path(const CapturedWindow& window, const PathModel& start, PathShape shape);

/// [control] By how much the delay of `fit` would be greater if `captured` stood in the window: in each band
/// of bins [edges[k], edges[k + 1]), to first order.
std::vector<double> delay_influences(const CapturedWindow& window, const Spectrum& captured,
                                     const PathFit& fit, std::span<const std::size_t> edges);

}  // namespace tactus
