#pragma once

// Thread: [realtime].

#include <cstdint>
#include <utility>

#include "engine/core/ramp.h"

namespace tactus {

/// What an edit of a running graph adds to one output so that it does not jump:
///   y(n) = x(n) + d (1 - (n - start) / length) until n = start + length,   d = y(start - 1) - x(start)
/// The first sample after the edit is the last one before it; from there on a step of y is one of x and
/// |d| / length at most.
class OutputFade {
 public:
  /// [control & stopped]
  void reset() noexcept { *this = {}; }
  /// [realtime] The next sample comes from another graph; `last` is the one before it.
  void begin(std::int64_t frame, std::int64_t frames, double last) noexcept {
    ramp_ = {0.0, 0.0, frame, frames};
    last_ = last;
    jump_unknown_ = true;
  }
  /// [realtime] What is added at a frame.
  double at(std::int64_t frame) const noexcept {
    return ramp_.done(frame) ? 0.0 : ramp_.from * ramp_.remaining(frame);
  }
  /// [realtime] In place.
  void process(double* samples, int frames, std::int64_t first_frame) noexcept {
    if (std::exchange(jump_unknown_, false)) ramp_.from = last_ - samples[0];
    const std::int64_t end = ramp_.start + ramp_.length;
    for (std::int64_t n = first_frame; n < end && n < first_frame + frames; ++n)
      samples[n - first_frame] += at(n);
  }

 private:
  Ramp ramp_;
  double last_ = 0;
  bool jump_unknown_ = false;
};

}  // namespace tactus
