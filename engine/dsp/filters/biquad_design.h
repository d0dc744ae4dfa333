#pragma once

// Thread: [any].

#include <algorithm>
#include <cmath>

#include "engine/dsp/filters/linear_filter.h"

namespace tactus {

/// A q that any filter can be designed for: [0.01, 1000], NaN included.
inline double clamped_q(double q) { return q > 0.01 ? std::min(q, 1000.0) : 0.01; }

/// Filters of order 2 after R. Bristow-Johnson, "Cookbook formulae for audio EQ biquad filter coefficients":
/// bilinear, prewarped at w = 2 pi f / fs [radians per frame], alpha = sin w / (2 q). At w a low-pass or
/// high-pass has gain q (-3.01 dB for q = 1/sqrt 2: Butterworth), a band-pass has gain 1. Valid for 0 < w <
/// pi, q > 0. Coefficients are exact to a few roundings; the poles of a filter with a very low cutoff are
/// not: expect a gain at 0 Hz within 2e-16 / w^2.
class BiquadDesign {
 public:
  BiquadDesign(double radians, double q)
      : cos_(std::cos(radians)),
        one_minus_cos_(2 * std::sin(radians / 2) * std::sin(radians / 2)),
        alpha_(std::sin(radians) / (2 * q)) {}

  FilterCoefficients<2> low_pass() const {
    return with(one_minus_cos_ / 2, one_minus_cos_, one_minus_cos_ / 2);
  }
  FilterCoefficients<2> high_pass() const { return with((1 + cos_) / 2, -(1 + cos_), (1 + cos_) / 2); }
  /// Peak gain 1; q = f / bandwidth (to -3.01 dB, before the warping of the frequency axis).
  FilterCoefficients<2> band_pass() const { return with(alpha_, 0, -alpha_); }

 private:
  FilterCoefficients<2> with(double b0, double b1, double b2) const {
    const double scale = 1 / (1 + alpha_);
    const double first = b0 * scale;
    // The same rounding for both ends and the middle keeps a zero at 0 Hz exactly there.
    return {.b = {first, b0 != 0 ? first * (b1 / b0) : 0, first * (b2 / b0)},
            .a = {2 * cos_ * scale, (alpha_ - 1) * scale}};
  }

  double cos_, one_minus_cos_, alpha_;
};

}  // namespace tactus
