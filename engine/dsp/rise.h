#pragma once

namespace tactus {

/// Fires in the one frame in which a trigger signal rises through 0.5. Before the first frame the signal
/// counts as low, so that a signal which starts high fires at once.
struct Rise {
  bool high = false;

  bool step(double trigger) {
    const bool was_high = high;
    high = trigger >= 0.5;
    return high && !was_high;
  }
};

}  // namespace tactus
