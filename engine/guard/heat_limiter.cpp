#include "engine/guard/heat_limiter.h"

#include <algorithm>

namespace tactus {

double fastest_rise(const HeatLimits& limits, double ceiling) noexcept {
  return limits.coil_share * ceiling * ceiling * (limits.watts_at_full_scale / limits.watts_for_ever) /
         limits.coil_time.value;
}

double rise_on_the_way_down(const HeatLimits& limits, double ceiling, double slew_per_second) noexcept {
  return fastest_rise(limits, ceiling) * ceiling / (3.0 * slew_per_second);
}

HeatLimiter::HeatLimiter(const HeatLimits& limits, double ceiling, double slew_per_second, Hertz sample_rate)
    : coil_share_(limits.coil_share) {
  const double s = limits.coil_share, coil = 1.0 / limits.coil_time.value,
               body = 1.0 / limits.body_time.value;
  free_ = exponential({-coil, coil, (1.0 - s) / s * body, -body / s}, kGuardGroup / sample_rate.value);
  // A steady power of 1 ends at coil 1, body 1 - s; what a group adds is how far it goes from there to here.
  const Vector2 end{1.0, 1.0 - s};
  per_square_ = (limits.watts_at_full_scale / limits.watts_for_ever) * (end - free_ * end);
  largest_rise_ = per_square_.x * ceiling * ceiling;
  way_down_ = rise_on_the_way_down(limits, ceiling, slew_per_second);
}

void HeatLimiter::end_group() noexcept {
  const double mean_square = squares_.take() / kGuardGroup;
  const auto [coil, body] = state();
  const Vector2 next = free_ * Vector2{coil, body} + mean_square * per_square_;
  warm(next.x, next.y);
}

void HeatLimiter::warm(double coil, double body) noexcept {
  coil_.store(coil, std::memory_order_relaxed);
  body_.store(body, std::memory_order_relaxed);
  gain_.move_to(allowed());
}

double HeatLimiter::allowed() const noexcept {
  const double left = std::max(0.0, 1.0 - way_down_ - state().coil);
  const double knee = std::min(1.0, left / kKnee);
  return 8.0 * largest_rise_ <= left ? knee : std::min(knee, std::sqrt(left / (8.0 * largest_rise_)));
}

void HeatLimiter::warm_to(const ThermalState& state) noexcept {
  // What comes from a file may be anything; ten times the limit is too warm for any drive.
  constexpr double kMost = 10.0;
  const auto now = this->state();
  warm(std::max(now.coil, std::min(state.coil, kMost)), std::max(now.body, std::min(state.body, kMost)));
  gain_.move_to(allowed());
}

}  // namespace tactus
