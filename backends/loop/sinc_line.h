#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "engine/core/index.h"

namespace tactus {

/// The past of a signal, read between its frames: a sinc under a Gaussian of 9 frames, cut off where that is
/// 1e-6. By the width of the Gaussian's spectrum, what lies below 0.42 of the rate is right to 1e-5, in gain
/// and in radians; whole frames are exact.
class SincLine {
 public:
  static constexpr int kReach = 48;  ///< frames on each side of where it is read

  /// [control] `back`: as far as it is read behind the newest frame that was written.
  explicit SincLine(std::int64_t back);

  /// [realtime] Frames begin at 0 and are all 0 at first.
  void add(std::int64_t frame, double value) noexcept { at(frame) += value; }
  /// [realtime] `frame` and what is behind it are of no use any more.
  void forget(std::int64_t frame) noexcept { at(frame) = 0.0; }
  /// [realtime] At `frame` + `fraction`, 0 <= fraction < 1.
  double read(std::int64_t frame, double fraction) noexcept;
  double operator[](std::int64_t frame) const noexcept { return samples_[index(frame) & mask_]; }

 private:
  double& at(std::int64_t frame) noexcept { return samples_[index(frame) & mask_]; }

  std::vector<double> samples_;
  std::size_t mask_;
  double fraction_ = 0.0;  ///< that `taps_` are for
  std::array<double, 2 * kReach> taps_{};
};

}  // namespace tactus
