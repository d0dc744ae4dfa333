#pragma once

#include <cstdint>
#include <utility>

namespace tactus {

/// What an edit of a running graph adds to one output so that it does not jump:
///   y(n) = x(n) + d (1 - (n - start) / length) until n = start + length,   d = y(start - 1) - x(start)
/// The first sample after the edit is the last one before it; from there on a step of y is one of x and
/// |d| / length at most.
class OutputFade {
 public:
  void reset() noexcept { *this = {}; }
  /// [realtime] The next sample comes from another graph; `last` is the one before it.
  void begin(std::int64_t frame, std::int64_t frames, double last) noexcept {
    start_ = frame;
    length_ = frames;
    last_ = last;
    jump_unknown_ = true;
  }
  /// [realtime] What is added at a frame.
  double at(std::int64_t frame) const noexcept {
    const std::int64_t left = start_ + length_ - frame;
    return left > 0 ? jump_ * (static_cast<double>(left) / static_cast<double>(length_)) : 0.0;
  }
  /// [realtime] In place.
  void process(double* samples, int frames, std::int64_t first_frame) noexcept {
    if (std::exchange(jump_unknown_, false)) jump_ = last_ - samples[0];
    const std::int64_t end = start_ + length_;
    for (std::int64_t n = first_frame; n < end && n < first_frame + frames; ++n)
      samples[n - first_frame] += at(n);
  }

 private:
  std::int64_t start_ = 0, length_ = 0;
  double jump_ = 0, last_ = 0;
  bool jump_unknown_ = false;
};

}  // namespace tactus
