#pragma once

#include <cmath>
#include <cstddef>
#include <span>

#include "engine/dsp/curves/catmull_rom.h"

namespace tactus {

/// Plays a recording from its start, at any speed. Before and behind the recording lies silence: the last
/// sample fades into it within one sample of the recording.
struct SamplePlayer {
  double position = -1;  ///< in samples of the recording; negative: not playing

  void start() { position = 0; }

  /// The value of this frame; then moves on by `increment` >= 0 samples. `cubic`: Catmull-Rom, else linear.
  double step(std::span<const double> recording, double increment, bool cubic) {
    if (position < 0) return 0;
    if (position >= static_cast<double>(recording.size())) return position = -1, 0.0;
    const auto index = static_cast<std::ptrdiff_t>(position);
    const double at = position - static_cast<double>(index);
    position += increment;
    const auto value = [&](std::ptrdiff_t i) {
      return i >= 0 && i < std::ssize(recording) ? recording[static_cast<std::size_t>(i)] : 0.0;
    };
    if (cubic) return catmull_rom(value(index - 1), value(index), value(index + 1), value(index + 2), at);
    return value(index) + at * (value(index + 1) - value(index));
  }
};

}  // namespace tactus
