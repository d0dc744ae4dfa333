#pragma once

#include <cmath>

namespace tactus {

/// Running phase in turns:  p[n+1] = frac(p[n] + f[n] / sample_rate),  0 <= p < 1.
/// Rounding adds at most 1.2e-16 turns a frame: below 1e-9 turns after an hour at 48 kHz if errors do not
/// line up, 2e-8 if they all do.
struct Phasor {
  double turns = 0;

  /// The phase of this frame; then moves on by `increment` turns of either sign.
  double step(double increment) {
    const double now = turns;
    turns += increment;
    turns -= std::floor(turns);
    // A tiny negative phase plus one rounds to one.
    if (turns >= 1) turns = 0;
    return now;
  }
};

}  // namespace tactus
