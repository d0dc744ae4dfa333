#pragma once

#include <array>
#include <atomic>
#include <cstdint>

#include "engine/core/matrix2.h"
#include "engine/guard/drive_limits.h"
#include "engine/guard/guard_group.h"

namespace tactus {

/// Limits the excursion of a mass on a spring that a drive moves.
/// In lengths of the limit and times of 1/ω0, with k = metres_at_full_scale / metres:
///
///   x'' = k y - x - x'/Q          advanced exactly, frame by frame, for a y that is held through the frame
///   r   = sqrt(x² + x'²)          never grows while y = 0: the energy only falls, and |x| <= r
///
/// A sample goes out as it is while, behind it, one of these still holds; each of them keeps holding if the
/// drive then returns to 0 as fast as its slew limit lets it (Δ a frame), so there is always a way back:
///
///   r + k ω0 T y² / (2 Δ)  <= 1 - h            what the return still pushes, at most; T: a frame's time
///   |k y| + r about (k y, 0)  <= 1 - h         a slow return carries the resting point with it
///   h = (k + 1 + 1/Q) (ω0 T)² / 8              between two frames the mass may bulge out by so much
///
/// Otherwise it goes only a share of the way from that return to where it wanted: both are convex in y, so
/// the chord between the two ends never promises too much.
///
/// Where the mass was before is known for one that starts at rest. Otherwise it may be anywhere with r <= u,
/// and what is left of that, u times the norm of the free motion since, is taken off the 1. So it is after a
/// gap of t: a card plays silence or an old block meanwhile, |y| <= c, and the model stood still, so it is
/// off by what it would have moved and what was pushed,
///
///   u <= ω0 t (1 + 1/Q + k c)  and at most 2 + k c
///
/// Where the mass is thrown beyond its limit by such a gap, the drive comes to 0 behind it. The model is that
/// of drive alone, without inductance (which would weaken the push); a hand or a stick can move the mass
/// further.
class ExcursionLimiter {
 public:
  /// [control] `largest_step`: of the drive from frame to frame; infinity: none.
  ExcursionLimiter(const ExcursionLimits& limits, double largest_step, Hertz sample_rate);

  /// [realtime] True if no sample of a block can reach the limit, whatever their order: only the sum of their
  /// absolute values is known, and a bound for each. Cheap, and errs to the side of no.
  bool stays_within(double sum_of_absolutes, double largest) const noexcept {
    return bound_ + push_ * sum_of_absolutes + return_push_ * largest * largest <= room_ - kRounding;
  }
  /// [realtime] What may go out instead of `wanted` behind `previous`, at `position` of the group.
  double allow(double wanted, double previous, int position) noexcept;
  /// [realtime] What went out at `position`.
  void record(double y, int position) noexcept { observed_[index(position)] = y; }
  /// [realtime] The outputs of part of a group.
  void observe(const double* samples, int frames, int position, double sum_of_absolutes) noexcept;
  /// [realtime] A group is over.
  void end_group() noexcept;

  /// [realtime] The mass may be at any place and speed with r <= `share` of the limit, besides what is known.
  void displace(double share) noexcept;
  /// [any] The displacement after a gap of so many frames in which something up to `ceiling` was played.
  double displacement_after(std::int64_t gap_frames, double ceiling) const noexcept;
  /// [any] What is left of that, at most.
  double displacement() const noexcept { return displacement_.load(std::memory_order_relaxed); }
  /// [any] At most how far the mass was from rest where the last whole group ended, as a share of the limit:
  /// r, and the displacement.
  double excursion() const noexcept {
    return norm_.load(std::memory_order_relaxed) + displacement_.load(std::memory_order_relaxed);
  }

 private:
  static constexpr double kRounding = 1e-9;

  Vector2 after(double y) const noexcept { return free_ * now_ + y * held_; }
  bool surely_within(Vector2 state, double y) const noexcept;
  double sudden(Vector2 state, double y) const noexcept;
  double steady(Vector2 state, double y) const noexcept;
  void catch_up(int position) noexcept;

  double drift_;        ///< (1 + 1/Q) ω0 T
  Matrix2 free_;        ///< over a frame
  Vector2 held_;        ///< what a frame of y = 1 adds
  Matrix2 group_free_;  ///< over a group
  double static_;       ///< k
  double push_;         ///< k ω0 T: what a frame of |y| = 1 adds to r at most
  double return_push_;  ///< push / (2 Δ)
  double largest_step_;
  double limit_;                                         ///< 1 - h
  double room_;                                          ///< what is left of it where the start is unknown
  Matrix2 since_;                                        ///< free motion since then, times u
  std::atomic<double> displacement_{0.0};                ///< its norm
  std::array<double, kGuardGroup> weight_x_, weight_y_;  ///< of the samples of a group in its end
  std::array<double, kGuardGroup> observed_{};           ///< the outputs of this group so far
  GroupSum sum_x_, sum_y_;
  Vector2 at_start_;               ///< of the group
  std::atomic<double> norm_{0.0};  ///< of that
  Vector2 now_;                    ///< before frame `known_` of the group
  int known_ = 0;
  double bound_ = 0.0;  ///< of r, before the next samples
};

}  // namespace tactus
