#pragma once
// Thread: [realtime] unless stated otherwise

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "engine/core/ramp.h"
#include "engine/core/realtime.h"
#include "engine/guard/dc_limiter.h"
#include "engine/guard/drive_limits.h"
#include "engine/guard/excursion_limiter.h"
#include "engine/guard/feedback_detector.h"
#include "engine/guard/heat_limiter.h"

namespace tactus {

/// How often a stage of the guard intervened: frames, and the largest reduction, in full scale.
struct StageCount {
  std::int64_t frames = 0;
  double most = 0.0;

  bool operator==(const StageCount&) const = default;
};

/// Indices of GuardCounts.
struct GuardStage {
  enum Index : std::size_t { NonFinite, Heat, Dc, Excursion, Ceiling, Slew, Feedback };
};
inline constexpr std::size_t kGuardStages = 7;

/// All stages of the guard of one channel.
using GuardCounts = std::array<StageCount, kGuardStages>;

/// The fixed last stage of one output channel:
///   finite    a NaN or infinity becomes 0
///   ceiling   y = clamp(x, -ceiling, ceiling)
///   gains     heat (heat_limiter.h), soft start, arm, mute, DC (dc_limiter.h): all at most 1
///   slew      y[n] = clamp(x[n], y[n-1] - s, y[n-1] + s),  s = slew_per_second / sample_rate,  y[-1] = 0
///   excursion excursion_limiter.h
/// The gains follow the ceiling: a gain on a signal that is a thousand times too large limits nothing.
/// Excursion is worked out behind the others, because what it lets through depends on what they leave;
/// whatever it gives lies within ceiling and slew again. Slew stays below the ceiling since it lies between
/// two values that do. Within its limits, and with the ramps at 1, the output is the input bit for bit; there
/// is no delay. The block size does not matter.
///
/// An output that returns to itself and grows (feedback_detector.h) fades out and stays silent until it is
/// opened again. While it is limited and may return, a gain g <= 1 is on it to find out:
///   y[n] = clamp(g x[n], y[n-1] - s, y[n-1] + s),  x: what the stages above would let out without it
class DriveGuard {
 public:
  enum class Kind {
    Drive,  ///< moves something: all stages
    Audio,  ///< for ears: finite, ramps, ceiling, feedback
  };
  /// A frame counts as limited by ceiling or excursion for this long after: peaks of a loop above 10 Hz.
  static constexpr Seconds kCrest{0.015};

  /// [control] `limits` must have passed `check`.
  DriveGuard(Kind kind, const DriveLimits& limits, Hertz sample_rate, FeedbackPath path = {});

  /// [realtime] Lets sound through from `frame` on (soft start), or fades it out. Asking twice changes
  /// nothing.
  void set_open(bool open, std::int64_t frame) noexcept;
  bool is_open() const noexcept { return gain_.to > 0.0; }
  /// [realtime] As if it had been opened long ago.
  void skip_soft_start() noexcept {
    if (is_open()) gain_ = Ramp::constant(1.0);
  }
  /// [realtime] Closed at once; writes the way to zero, within the slew limit. True: it ends at zero.
  bool stop(double* samples, int frames) noexcept;
  /// [realtime] Closed, and at zero before `frame`.
  bool at_rest(std::int64_t frame) const noexcept {
    return gain_.to == 0.0 && gain_.done(frame) && last_ == 0.0;
  }

  /// [realtime] In place. `first_frame`: number of samples[0] since the start; frames come one after another.
  void process(double* samples, int frames, std::int64_t first_frame) noexcept TACTUS_NONBLOCKING;

  /// [realtime] The frame at which detected feedback made it fade, once.
  std::optional<std::int64_t> take_feedback() noexcept;
  /// [any] Cold if there is no heat limit.
  ThermalState thermal_state() const noexcept { return heat_ ? heat_->state() : ThermalState{}; }
  /// [realtime] Only ever warmer.
  void warm_to(const ThermalState& state) noexcept {
    if (heat_) heat_->warm_to(state);
  }

  /// [any] How far the mass may be from rest, as a share of its limit.
  double excursion() const noexcept { return excursion_ ? excursion_->excursion() : 0.0; }
  /// [any] How far the mass may be from where the model has it, as a share of its limit.
  double displacement() const noexcept { return excursion_ ? excursion_->displacement() : 0.0; }
  /// [any] The same after a gap of so many frames, in which a card may play what it likes within the ceiling.
  double displacement_after(std::int64_t gap_frames) const noexcept {
    return excursion_ ? excursion_->displacement_after(gap_frames, ceiling_) : 0.0;
  }
  /// [realtime] At least so far.
  void displace(double share) noexcept {
    if (excursion_) excursion_->displace(share);
  }
  /// [control & stopped] What the actuator did before is unknown: it is as warm as it may stay, its mass may
  /// be at its limit, and DC may have lasted for all of its time.
  void suppose_worst() noexcept {
    if (heat_) heat_->warm_to(heat_->warmest());
    displace(1.0);
    dc_.spend(dc_.most_s());
  }

  /// [control & stopped] How long DC has lasted (dc_limiter.h).
  double dc_time_s() const noexcept { return dc_.spent_s(); }
  /// [realtime] At least so long.
  void spend_dc_time(double seconds) noexcept { dc_.spend(seconds); }
  /// [control & stopped]
  const FeedbackPath& feedback_path() const noexcept { return feedback_.path(); }
  /// [realtime] From here on also through this path.
  void add_feedback_path(const FeedbackPath& path) noexcept { feedback_.add(path); }

  Kind kind() const noexcept { return kind_; }
  /// [any]
  GuardCounts counts() const noexcept;

 private:
  bool passes(const double* samples, int frames, std::int64_t first_frame,
              double sum_of_absolutes) const noexcept;
  double shape(double sample, double& wanted, std::int64_t frame, int position) noexcept;
  double held_back(double from, double to, GuardStage::Index stage, std::int64_t frame,
                   std::int64_t hold) noexcept;
  double scaled(double x, double gain, GuardStage::Index stage) noexcept;
  void count(double less, GuardStage::Index stage) noexcept;
  double within(double x, double last) const noexcept;
  void end_group(std::int64_t frame) noexcept;

  Kind kind_;
  double ceiling_;
  double largest_step_;
  std::int64_t rise_frames_, fall_frames_;
  std::int64_t crest_frames_, swing_frames_;  ///< that a limited frame counts for; slew: two full swings
  Ramp gain_;
  std::optional<HeatLimiter> heat_;
  std::optional<ExcursionLimiter> excursion_;
  DcLimiter dc_;
  FeedbackDetector feedback_;
  std::optional<std::int64_t> feedback_frame_;
  double last_ = 0.0;          ///< of the output
  double last_allowed_ = 0.0;  ///< before the probe
  struct Counter {
    std::atomic<std::int64_t> frames{0};
    std::atomic<double> most{0.0};
  };
  std::array<Counter, kGuardStages> counters_;
};

}  // namespace tactus
