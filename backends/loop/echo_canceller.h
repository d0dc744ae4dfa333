#pragma once

#include <array>
#include <cstdint>

#include "backends/loop/sinc_line.h"
#include "engine/core/index.h"

namespace tactus {

/// Removes from the recording what it can predict from what was played, as voice chat programs do: an
/// adaptive filter by normalised least mean squares,
///   e[n] = y[n] - w·u[n],   w += mu e[n] u[n] / (u[n]·u[n] + eps),   u[n] = what was played around n - D.
/// Source: S. Haykin, "Adaptive Filter Theory", 4th ed., chapter 6.
class EchoCanceller {
 public:
  /// How far ahead of the delay it looks.
  static constexpr int kAhead = SincLine::kReach;

  /// [realtime] `newest`: the frame of `played` with which it begins.
  double step(const SincLine& played, std::int64_t newest, double heard) noexcept {
    double made = 0.0, power = 0.0;
    for (int k = 0; k < kTaps; ++k) {
      const double sample = played[newest - k];
      made += weights_[index(k)] * sample;
      power += sample * sample;
    }
    const double left = heard - made;
    const double push = kStep * left / (power + kLeastPower);
    for (int k = 0; k < kTaps; ++k) weights_[index(k)] += push * played[newest - k];
    return left;
  }

 private:
  static constexpr int kTaps = 128;
  static constexpr double kStep = 0.005;
  static constexpr double kLeastPower = 1e-7;

  std::array<double, kTaps> weights_{};
};

}  // namespace tactus
