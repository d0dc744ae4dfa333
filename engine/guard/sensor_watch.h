#pragma once
// Thread: [realtime] unless stated otherwise

#include <cstdint>
#include <optional>

#include "engine/core/units.h"

namespace tactus {

/// Detects faults of one sensor:
///   railed   at the same end of full scale (99.9 %) for 40 ms: a loose cable or a missing supply
///   stuck    the same value bit for bit for 40 ms, after noise was observed: a converter or a driver hangs
/// A resting computed signal has no noise: in one window of 512 frames the signal turns back in
/// more than a third of them (white noise: two thirds; a tone at a tenth of the sample rate: a fifth). A
/// sensor that was never noisy, such as a simulated one, may rest for any time.
class SensorWatch {
 public:
  enum class Fault { Railed, Stuck };
  static constexpr Seconds kPatience{0.04};
  static constexpr double kRail = 0.999;

  explicit SensorWatch(Hertz sample_rate)
      : patience_(static_cast<std::int64_t>(frames_in(kPatience, sample_rate))) {}

  struct Found {
    int frame;  ///< of the block
    Fault fault;
  };
  /// [realtime] The first fault, once until `rearm`. Frames come one after another; the block size does not
  /// matter.
  std::optional<Found> observe(const double* samples, int frames) noexcept;
  /// [realtime] The user armed again: the 40 ms start anew. The noise state is kept.
  void rearm() noexcept {
    same_ = railed_ = 0;
    reported_ = false;
  }
  /// [control & stopped] Noise was observed: the sensor lives, and may be found stuck.
  bool is_noisy() const noexcept { return noisy_; }
  /// [realtime] It was observed before.
  void set_noisy() noexcept { noisy_ = true; }

 private:
  static constexpr int kWindow = 512;

  std::optional<Found> observe_part(const double* samples, int frames) noexcept;
  void detect_noise(int frames) noexcept;

  std::int64_t patience_;
  std::int64_t same_ = 0, railed_ = 0;  ///< frames so far
  double last_ = 0.0, before_ = 0.0;
  int observed_ = 0, turns_ = 0;  ///< in this window
  bool noisy_ = false, reported_ = false;
};

}  // namespace tactus
