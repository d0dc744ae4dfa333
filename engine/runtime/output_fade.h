#pragma once

#include <cstdint>

namespace tactus {

/// What an edit of a running graph adds to one output so that it does not jump:
///   y(n) = x(n) + d (1 - (n - start) / length) until n = start + length,   d = y(start - 1) - x(start)
/// The first sample after the edit is the last one before it; from there on a step of y is one of x and
/// |d| / length at most.
class OutputFade {
 public:
  void reset() noexcept { *this = {}; }
  /// [realtime] The next sample comes from another graph.
  void begin(std::int64_t frame, std::int64_t frames) noexcept {
    start_ = frame;
    length_ = frames;
    jump_unknown_ = true;
  }
  /// [realtime] In place. Remembers the last sample.
  void process(double* samples, int frames, std::int64_t first_frame) noexcept {
    if (jump_unknown_) {
      jump_ = last_ - samples[0];
      jump_unknown_ = false;
    }
    const std::int64_t end = start_ + length_;
    for (std::int64_t n = first_frame; n < end && n < first_frame + frames; ++n)
      samples[n - first_frame] += jump_ * (static_cast<double>(end - n) / static_cast<double>(length_));
    last_ = samples[frames - 1];
  }

 private:
  std::int64_t start_ = 0, length_ = 0;
  double jump_ = 0, last_ = 0;
  bool jump_unknown_ = false;
};

}  // namespace tactus
