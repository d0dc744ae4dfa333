#pragma once
// Thread: [realtime] unless stated otherwise

#include <atomic>

#include "engine/core/matrix2.h"
#include "engine/guard/drive_limits.h"
#include "engine/guard/guard_group.h"

namespace tactus {

/// How warm an actuator is, as a share of the rise that it may have: 0 is as cold as the room, 1 the limit.
struct ThermalState {
  double coil = 0.0, body = 0.0;

  bool operator==(const ThermalState&) const = default;
};

/// [any] A second: s c² P / τ_c with c the ceiling and P the power of full scale over that which leads to the
/// limit.
double fastest_rise(const HeatLimits& limits, double ceiling) noexcept;
/// [any] The integral of it along a ramp from the ceiling to 0.
double rise_on_the_way_down(const HeatLimits& limits, double ceiling, double slew_per_second) noexcept;

/// Thermal model of a coil that a drive feeds, and the gain that keeps its temperature within the limit.
///
///   τ_c T_c' = s p - (T_c - T_b)                        T: rise over the limit; p: power over that which
///   τ_b T_b' = (1 - s)/s (T_c - T_b) - T_b              leads to the limit; s: the coil's share
///
/// is advanced exactly, group by group, with the group's mean power. The resistance is the cold one and all
/// electrical power counts as heat: a warm coil draws less, so the model errs to the warm side.
///
///   gain = 1 while 1 - w - T_c >= 0.2, from there down to 0 at T_c = 1 - w, and g² a <= (1 - w - T_c) / 8
///
/// with a <= 1/8 what a group at the ceiling adds, and w <= 1/8 what is added on the way from the ceiling
/// down to 0, which takes time where there is a slew limit (`check` sees to both): T_c < 1 for ever. Sources:
/// the two time constants of voice coil and magnet, W. Klippel, "Nonlinear modeling of the heat transfer in
/// loudspeakers", JAES 52, 2004; the equations are those of two RC links in a chain.
class HeatLimiter {
 public:
  static constexpr double kKnee = 0.2;

  /// [control]
  HeatLimiter(const HeatLimits& limits, double ceiling, double slew_per_second, Hertz sample_rate);

  /// [realtime] The outputs of part of a group.
  void observe(const double* samples, int frames, int position) noexcept {
    squares_.add(position, frames, [samples](int n) { return samples[n] * samples[n]; });
  }
  /// [realtime] A group is over.
  void end_group() noexcept;

  const GroupGain& gain() const noexcept { return gain_; }
  /// [any]
  ThermalState state() const noexcept {
    return {coil_.load(std::memory_order_relaxed), body_.load(std::memory_order_relaxed)};
  }
  /// [realtime] Only ever warmer than it was: what is restored must not be optimistic.
  void warm_to(const ThermalState& state) noexcept;
  /// [any] The warmest that lasts: where a steady power leads to the limit.
  ThermalState warmest() const noexcept { return {1.0, 1.0 - coil_share_}; }

 private:
  void warm(double coil, double body) noexcept;
  double allowed() const noexcept;

  Matrix2 free_;        ///< over a group
  Vector2 per_square_;  ///< what a group with a mean square of 1 adds
  double coil_share_;
  double largest_rise_;
  double way_down_;
  GroupSum squares_;
  GroupGain gain_;
  std::atomic<double> coil_{0.0}, body_{0.0};
};

}  // namespace tactus
