#pragma once

#include <vector>

#include "engine/core/units.h"

namespace tactus {

/// How an actuator, what it moves, and the sensor that hears it answer together: an impulse response from the
/// sample that leaves the card to the sample that the card hears, with the card's own delay taken off.
struct PathProfile {
  Hertz sample_rate = 48_kHz;
  std::vector<double> taps;  ///< captured[n] = sum of taps[k] played[n - k]
  Hertz low, high;           ///< between these it is known
};

}  // namespace tactus
