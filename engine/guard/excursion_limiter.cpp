#include "engine/guard/excursion_limiter.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "engine/core/index.h"

namespace tactus {
namespace {

double length(Vector2 v) noexcept { return std::sqrt(v.x * v.x + v.y * v.y); }

/// By how much a matrix stretches at most.
double norm(const Matrix2& m) noexcept {
  const double sum = m.a * m.a + m.b * m.b + m.c * m.c + m.d * m.d, determinant = m.a * m.d - m.b * m.c;
  return std::sqrt(0.5 * (sum + std::sqrt(std::max(0.0, sum * sum - 4.0 * determinant * determinant))));
}

/// Towards 0 by at most `step`.
double returned(double y, double step) noexcept {
  return y > 0.0 ? std::max(0.0, y - step) : std::min(0.0, y + step);
}

}  // namespace

ExcursionLimiter::ExcursionLimiter(const ExcursionLimits& limits, double largest_step, Hertz sample_rate)
    : static_(limits.metres_at_full_scale / limits.metres), largest_step_(largest_step) {
  const double turn = 2.0 * std::numbers::pi * limits.resonance.value / sample_rate.value;
  drift_ = (1.0 + 1.0 / limits.q) * turn;
  free_ = exponential({0.0, 1.0, -1.0, -1.0 / limits.q}, turn);
  const Vector2 rest{static_, 0.0};
  held_ = rest - free_ * rest;
  push_ = static_ * turn;
  return_push_ = push_ / (2.0 * largest_step);
  limit_ = std::max(0.0, 1.0 - (static_ + 1.0 + 1.0 / limits.q) * turn * turn / 8.0);
  room_ = limit_;
  group_free_ = {1.0, 0.0, 0.0, 1.0};
  Vector2 weight = held_;
  for (std::size_t n = kGuardGroup; n-- > 0; weight = free_ * weight, group_free_ = free_ * group_free_) {
    weight_x_[n] = weight.x;
    weight_y_[n] = weight.y;
  }
}

double ExcursionLimiter::sudden(Vector2 state, double y) const noexcept {
  return length(state) + return_push_ * y * y;
}

/// `sudden` without its root.
bool ExcursionLimiter::surely_within(Vector2 state, double y) const noexcept {
  const double room = room_ - kRounding - return_push_ * y * y;
  return room > 0.0 && state.x * state.x + state.y * state.y <= room * room;
}

double ExcursionLimiter::steady(Vector2 state, double y) const noexcept {
  return std::abs(static_ * y) + length({state.x - static_ * y, state.y});
}

double ExcursionLimiter::allow(double wanted, double previous, int position) noexcept {
  catch_up(position);
  const auto there = after(wanted);
  if (surely_within(there, wanted)) return wanted;
  const double suddenly = sudden(there, wanted), steadily = steady(there, wanted);
  if (suddenly <= room_ || steadily <= room_) return wanted;
  const double back = returned(previous, largest_step_);
  const auto home = after(back);
  const auto share = [this](double from, double to) {
    return from < room_ ? (room_ - from) / (to - from) : 0.0;
  };
  const double most = std::max(share(sudden(home, back), suddenly), share(steady(home, back), steadily));
  return back + most * (wanted - back);
}

void ExcursionLimiter::catch_up(int position) noexcept {
  for (; known_ < position; ++known_) now_ = after(observed_[index(known_)]);
}

void ExcursionLimiter::observe(const double* samples, int frames, int position,
                               double sum_of_absolutes) noexcept {
  const double* x = weight_x_.data() + position;
  const double* y = weight_y_.data() + position;
  sum_x_.add(position, frames, [=](int n) { return x[n] * samples[n]; });
  sum_y_.add(position, frames, [=](int n) { return y[n] * samples[n]; });
  std::copy_n(samples, frames, observed_.data() + position);
  bound_ += push_ * sum_of_absolutes;
}

void ExcursionLimiter::end_group() noexcept {
  at_start_ = group_free_ * at_start_ + Vector2{sum_x_.take(), sum_y_.take()};
  now_ = at_start_;
  known_ = 0;
  bound_ = length(at_start_);
  norm_.store(bound_, std::memory_order_relaxed);
  if (displacement() == 0.0) return;
  constexpr double kForgotten = 1e-6;
  since_ = group_free_ * since_;
  const double left = norm(since_);
  displacement_.store(left < kForgotten ? 0.0 : left, std::memory_order_relaxed);
  room_ = std::max(0.0, limit_ - displacement());
}

double ExcursionLimiter::displacement_after(std::int64_t gap_frames, double ceiling) const noexcept {
  const double moved = (drift_ + push_ * ceiling) * static_cast<double>(gap_frames);
  return std::min(displacement() + moved, 2.0 + static_ * ceiling);
}

void ExcursionLimiter::displace(double share) noexcept {
  if (share <= displacement()) return;
  since_ = {share, 0.0, 0.0, share};
  displacement_.store(share, std::memory_order_relaxed);
  room_ = std::max(0.0, limit_ - share);
}

}  // namespace tactus
