#pragma once
// Thread: [realtime] unless stated otherwise

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

namespace tactus {

/// Finds frames that went missing although no driver said so, by the clock: blocks come late for many reasons
/// but never early, so the earliest block of each half second shows where the stream stands. When it falls
/// behind that of the half second before by more than a block and by more than two clocks drift apart (0.2
/// %), frames are missing.
///
/// Theory: with F frames brought until time t, e = F / rate - t is at most a constant while nothing is lost;
/// a loss of L frames lowers its maximum by L / rate.
class FrameWatch {
 public:
  static constexpr double kWindowSeconds = 0.5;
  static constexpr double kDrift = 0.002;

  explicit FrameWatch(double sample_rate_hz) : rate_(sample_rate_hz) {}

  /// [realtime] A block that begins at frame `frames` of the stream came at `seconds`. Returns how many
  /// frames were found missing.
  std::int64_t block(std::int64_t frames, int block_frames, double seconds) noexcept {
    if (!begun_) {
      begun_ = true;
      window_end_ = seconds + kWindowSeconds;
    }
    const double early = static_cast<double>(frames) / rate_ - seconds;
    std::int64_t missing = 0;
    if (seconds >= window_end_) {
      const double fallen = before_ - earliest_;
      const double usual =
          std::max(block_frames / rate_, kDrift * (seconds - window_end_ + 2 * kWindowSeconds));
      if (known_ && fallen > usual) missing = std::llround(fallen * rate_);
      before_ = earliest_;
      known_ = true;
      earliest_ = -std::numeric_limits<double>::infinity();
      window_end_ = seconds + kWindowSeconds;
    }
    earliest_ = std::max(earliest_, early);
    return missing;
  }

 private:
  double rate_;
  bool begun_ = false, known_ = false;
  double window_end_ = 0.0;
  double before_ = 0.0;
  double earliest_ = -std::numeric_limits<double>::infinity();
};

}  // namespace tactus
