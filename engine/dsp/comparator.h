#pragma once

namespace tactus {

/// A comparator with hysteresis (Schmitt trigger): high from the frame in which `in` reaches `level`, low
/// from the frame in which it falls below `level - hysteresis`.
struct Comparator {
  bool high = false;

  /// True in the frame in which it goes high.
  bool step(double in, double level, double hysteresis) {
    const bool was_high = high;
    high = was_high ? in >= level - hysteresis : in >= level;
    return high && !was_high;
  }
};

}  // namespace tactus
