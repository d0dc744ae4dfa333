#include "engine/study/walls/virtual_wall.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

#include "engine/core/find_root.h"
#include "engine/study/walls/held_mass.h"

namespace tactus {

double stiffest_by_damping(const WallDevice& device, const WallLoop& loop) {
  return std::max(0.0, device.damping + loop.damping) / loop.lag();
}

double stiffest_behind_delay(const WallDevice& device, Seconds lag) {
  assert(lag.value > 0);
  const double ratio = device.damping * lag.value / device.mass;
  if (ratio <= 0) return 0;
  const double phi = root_between(0, 0.5 * std::numbers::pi,
                                  [&](double x) { return x * std::sin(x) - ratio * std::cos(x); });
  return device.damping / lag.value * phi / std::sin(phi);
}

double stiffest_undelayed(const WallDevice& device, Hertz rate) {
  // The formula's differences, without their cancellation: see held_mass.h.
  const auto held = HeldMass::over(device.mass, device.damping, 1 / rate.value);
  const double lost = -std::expm1(-device.damping / (device.mass * rate.value));
  return lost / (held.reach * held.gain - held.keep * held.rise);
}

double stiffest_passive(const WallDevice& device, const WallLoop& loop) {
  return std::max(0.0, device.damping - std::abs(loop.damping)) / loop.lag();
}

double stiffest_by_friction(const WallDevice& device) {
  return device.quantum > 0 ? 2 * device.friction / device.quantum : std::numeric_limits<double>::infinity();
}

std::optional<EdgeCycle> encoder_edge_cycle(const WallDevice& device, double stiffness, Seconds lag) {
  assert(device.damping > 0 && device.quantum > 0 && lag.value > 0);
  const double push = 0.5 * stiffness * device.quantum;
  if (device.friction >= push) return std::nullopt;
  // Amplitudes are in proportion to M: with M = b, speeds are relative to the last one, M/b.
  const double a = device.damping / device.mass;
  const auto fallen = [&](double t) { return t * HeldMass::phi1(a * t); };
  const auto position = [&](double h, double t) {
    const double v0 = -std::tanh(0.5 * a * h);
    const double x0 = -0.5 * (h + (v0 - 1) * fallen(h));
    return x0 + t + (v0 - 1) * fallen(t);
  };
  // At the edge after h - tau. Just above tau it is not there yet, far above it long was.
  double far = 2 * lag.value;
  while (position(far, far - lag.value) < 0) far *= 2;
  const double h = root_between(lag.value, far, [&](double t) { return position(t, t - lag.value); });
  const double turn = std::log1p(std::tanh(0.5 * a * h)) / a;  // where its speed is 0
  return EdgeCycle{Hertz{0.5 / h}, -position(h, turn) * push / device.damping / device.quantum};
}

double wall_rebound(double mass, double stiffness, Seconds lag) {
  const double half = 0.5 * std::sqrt(stiffness / mass) * lag.value;
  assert(half < 1);
  return std::exp(std::numbers::pi * half / std::sqrt(1 - half * half));
}

double cut_cycle_amplitude(double stiffness, double border, double force_limit) {
  assert(border > 0 && border < stiffness && std::isfinite(force_limit));
  // Over s = 1/r, from 0 (all cut) to 1 (nothing cut): the share of the stiffness that is left rises.
  const auto left = [](double s) { return 2 / std::numbers::pi * (std::asin(s) + s * std::sqrt(1 - s * s)); };
  const double s = root_between(0, 1, [&](double x) { return left(x) - border / stiffness; });
  return force_limit / (stiffness * s);
}

}  // namespace tactus
