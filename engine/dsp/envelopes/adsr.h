#pragma once

#include <algorithm>

#include "engine/core/realtime.h"

namespace tactus {

/// Attack, decay, sustain, release. In each frame, e being the value of the frame before:
///   gate rises:      attack from where it is
///   attack:          e + rise, but not above 1; at 1 the decay begins
///   decay, sustain:  sustain + decay_keep * (e - sustain)
///   gate low:        release_keep * e
/// `rise` is 1 / (sample_rate * attack), the `keep`s are those of a `TimeConstant`.
struct Adsr {
  double value = 0;
  bool gate_high = false;
  bool attacking = false;

  struct Rates {
    double rise, decay_keep, sustain, release_keep;
  };

  double step(double gate, const Rates& rates) {
    const bool high = gate >= 0.5;
    if (high && !gate_high) attacking = true;
    gate_high = high;
    if (!high) {
      value *= rates.release_keep;
    } else if (attacking) {
      value = std::min(1.0, value + rates.rise);
      attacking = value < 1.0;
    } else {
      value = fused_multiply_add(rates.decay_keep, value - rates.sustain, rates.sustain);
    }
    return value;
  }
};

}  // namespace tactus
