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

  /// Whether none of `count` frames changes anything; then they may be left out.
  bool indifferent(const double* trigger, int count) const {
    if (high) return false;
    int above = 0;
    for (int n = 0; n < count; ++n) above += trigger[n] >= 0.5;
    return above == 0;
  }
};

}  // namespace tactus
