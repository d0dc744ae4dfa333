#pragma once

// Thread: [any].

#include <cmath>

#include "engine/dsp/filters/linear_filter.h"

namespace tactus {

/// One pole, by the bilinear transform prewarped at the cutoff: exactly -3.01 dB and -45 degrees there at
/// every rate, gain 1 at 0 Hz, 0 at half the rate. With p = (1 - tan(w/2)) / (1 + tan(w/2)), w = 2 pi fc /
/// fs:
///
///   H(z) = (1 - p)/2 (1 + z^-1) / (1 - p z^-1)          and 1 - H is the high-pass with the same cutoff.
///
/// Source: Oppenheim & Schafer, Discrete-Time Signal Processing, 7.1.2.
inline FilterCoefficients<1> one_pole_low_pass(double radians) {
  const double t = std::tan(radians / 2);
  const double gain = t / (1 + t);  // (1 - p) / 2 without the cancellation
  return {.b = {gain, gain}, .a = {(1 - t) / (1 + t)}};
}

/// The pole p of H(z) = (1 - p) / (1 - p z^-1) that is exactly -3.01 dB at the cutoff:
///
///   p^2 - 2 c p + 1 = 0,  c = 2 - cos w,  so 1 - p = sqrt(c^2 - 1) - (c - 1)
///
/// It lags half a frame less than the bilinear one and passes a little at half the rate: the choice where a
/// filter stands in a control loop. Returns 1 - p, which small cutoffs do not cancel.
inline double matched_one_pole_gain(double radians) {
  const double s = std::sin(radians / 2);
  const double c_minus_1 = 2 * s * s;
  return std::sqrt(c_minus_1 * (c_minus_1 + 2)) - c_minus_1;
}

/// y = (1 - p) x + p y1 with that pole.
inline FilterCoefficients<1> matched_one_pole(double radians) {
  const double gain = matched_one_pole_gain(radians);
  return {.b = {gain}, .a = {1 - gain}};
}

/// y = p (y1 + x - x1), p = 1 / (1 + 2 pi fc / fs): an RC high-pass by backward Euler, as audio inputs have
/// one. -3.01 dB at the cutoff for fc << fs (within 1 % of it below fs / 600).
inline FilterCoefficients<1> dc_blocker(double radians) {
  const double p = 1 / (1 + radians);
  return {.b = {p, -p}, .a = {p}};
}

/// A difference in units per second, then the matched one-pole: the velocity of a position. A ramp of slope
/// 1/s comes out as exactly 1.
inline FilterCoefficients<1> filtered_velocity(double radians, Hertz sample_rate) {
  const double gain = matched_one_pole_gain(radians);
  return {.b = {gain * sample_rate.value, -gain * sample_rate.value}, .a = {1 - gain}};
}

}  // namespace tactus
