#pragma once

// Thread: [any].

#include <algorithm>
#include <cmath>

#include "engine/core/units.h"

namespace tactus {

/// A delay as whole frames and what is left, from 0 on and below 1. What is within a billionth of a whole
/// frame is whole.
struct SplitDelay {
  SplitDelay(Seconds delay, Hertz rate) {
    const double frames = frames_in(delay, rate);
    whole = static_cast<int>(std::floor(frames + 1e-9));
    fraction = std::max(0.0, frames - whole);
    if (fraction < 1e-9) fraction = 0;
  }

  int whole;
  double fraction;
};

}  // namespace tactus
