#pragma once

#include <cmath>
#include <cstdint>

#include "engine/graph/plan/schedule.h"

namespace tactus {

/// A number that moves on a straight line (in decibels if it is read so) between two absolute frames:
///   v(n) = from + (to - from) (n - start) / length,   v = to from n = start + length on.
struct MovingValue {
  double from = 0, to = 0;
  std::int64_t start = 0, length = 0;

  static MovingValue resting(double value) { return {value, value, 0, 0}; }
  bool done(std::int64_t frame) const noexcept { return frame - start >= length; }
  double at(std::int64_t frame, bool decibel) const noexcept {
    if (done(frame)) return to;
    const double position = static_cast<double>(frame - start) / static_cast<double>(length);
    if (decibel && from > 0 && to > 0) return from * std::pow(to / from, position);
    return from + (to - from) * position;
  }
};

/// A MovingValue that steps of a schedule read: one number with stride 0 while it rests, a sample a frame
/// while it moves.
struct Mover {
  MovingValue value;
  double* buffer = nullptr;  ///< nullptr: nobody reads it
  Readers readers;
  bool decibel = false;
  bool resting = true;
};

}  // namespace tactus
