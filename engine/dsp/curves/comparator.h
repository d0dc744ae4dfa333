#pragma once

#include <cstdint>

namespace tactus {

/// A comparator with hysteresis (Schmitt trigger): high from the frame in which `in` reaches `level`, low
/// from the frame in which it falls below `level - hysteresis`. It fires once for each time it was low: when
/// `in` is at `level` or above and `wait` is over, which the caller may set to frames when it fires.
struct Comparator {
  bool high = false;
  bool armed = true;
  std::int64_t wait = 0;  ///< frames until it may fire again

  /// True in the frame in which it fires.
  bool step(double in, double level, double hysteresis) {
    if (wait > 0) --wait;
    const bool reached = in >= level, let_go = !(in >= level - hysteresis);
    high = high ? !let_go : reached;
    armed = armed || let_go;
    const bool fires = armed && reached && wait == 0;
    armed = armed && !fires;
    return fires;
  }

  /// Whether none of `count` frames changes anything; then they may be left out, but for `pass`.
  bool indifferent(const double* in, int count, double level, double hysteresis) const {
    if (high == armed) return false;
    int beyond = 0;
    if (high)
      for (int n = 0; n < count; ++n) beyond += !(in[n] >= level - hysteresis);
    else
      for (int n = 0; n < count; ++n) beyond += in[n] >= level;
    return beyond == 0;
  }
  void pass(int count) { wait = wait > count ? wait - count : 0; }
};

}  // namespace tactus
