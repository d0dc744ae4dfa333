#pragma once

#include <cstdint>

namespace tactus {

/// A gain that moves on a straight line between two absolute frames, so that no block size enters:
///   g(n) = from + (to - from) (n - start) / length,   g = to from n = start + length on.
class GainRamp {
 public:
  explicit GainRamp(double gain) : from_(gain), to_(gain) {}

  /// [realtime] From the gain at `frame` to `target` in `length` frames.
  void begin(std::int64_t frame, std::int64_t length, double target) noexcept {
    from_ = at(frame);
    to_ = target;
    start_ = frame;
    length_ = length;
  }
  double at(std::int64_t frame) const noexcept {
    const auto elapsed = frame - start_;
    if (elapsed < 0) return from_;
    if (elapsed >= length_) return to_;
    return from_ + (to_ - from_) * (static_cast<double>(elapsed) / static_cast<double>(length_));
  }
  bool at_rest(std::int64_t frame) const noexcept { return frame - start_ >= length_; }
  double target() const noexcept { return to_; }

 private:
  double from_, to_;
  std::int64_t start_ = 0, length_ = 0;
};

}  // namespace tactus
