#pragma once

#include <cstdint>

namespace tactus {

/// A pulse that jumps to a level and decays:  out[n] = level * keep^n,  n frames after `start`; 0 once n has
/// reached `length` frames (0: never).
struct Pulse {
  double value = 0;
  std::int64_t age = 0;

  void start(double level) {
    value = level;
    age = 0;
  }
  /// The value of this frame; then one frame on.
  double step(double keep, double length_frames) {
    if (length_frames > 0 && static_cast<double>(age) + 0.5 >= length_frames) value = 0;
    const double now = value;
    value *= keep;
    ++age;
    return now;
  }
  /// `count` steps with the same arguments.
  void run(double* out, int count, double keep, double length_frames) {
    if (length_frames > 0) {
      for (int n = 0; n < count; ++n) out[n] = step(keep, length_frames);
      return;
    }
    double now = value;
    for (int n = 0; n < count; ++n) {
      out[n] = now;
      now *= keep;
    }
    value = now;
    age += count;
  }
};

}  // namespace tactus
