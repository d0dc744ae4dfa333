#pragma once
// Thread: [any]

#include <cmath>
#include <cstdint>

namespace tactus {

/// A value that moves on a straight line between two absolute frames, so that the block size has no effect:
///   v(n) = from + (to - from) p(n),   p(n) = (n - start) / length,   v = to from n = start + length on.
struct Ramp {
  double from = 0.0, to = 0.0;
  std::int64_t start = 0, length = 0;

  static Ramp constant(double value) noexcept { return {value, value, 0, 0}; }
  /// From the value at `frame` to `target` in `frames`.
  void move_to(double target, std::int64_t frame, std::int64_t frames) noexcept {
    *this = {at(frame), target, frame, frames};
  }
  bool done(std::int64_t frame) const noexcept { return frame - start >= length; }
  double at(std::int64_t frame) const noexcept {
    if (frame < start) return from;
    return done(frame) ? to : at_progress(progress(frame));
  }
  /// A straight line in decibels; the same as `at` unless both ends are positive.
  double decibel_at(std::int64_t frame) const noexcept {
    if (!(from > 0 && to > 0) || done(frame)) return at(frame);
    return from * std::pow(to / from, progress(frame));
  }
  double at_progress(double progress) const noexcept { return from + (to - from) * progress; }
  /// p(n), and 1 - p(n) rounded once; for frames of the ramp.
  double progress(std::int64_t frame) const noexcept { return share(frame - start); }
  double remaining(std::int64_t frame) const noexcept { return share(start + length - frame); }

 private:
  double share(std::int64_t frames) const noexcept {
    return static_cast<double>(frames) / static_cast<double>(length);
  }
};

}  // namespace tactus
