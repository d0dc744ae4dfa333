#pragma once

#include <Eigen/Eigenvalues>
#include <cassert>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include "engine/core/find_root.h"
#include "engine/study/walls/virtual_wall.h"

// What theory says of virtual walls: numbers to test the engine against.
namespace tactus::test {

/// K = (b / tau) phi / sin phi with phi tan phi = b tau / m: a device in continuous time behind a delay tau
/// [s], B = 0, for any b tau / m; the factor grows from 1 to pi/2. Right where T << tau. From the root
/// s = j phi / tau of m s^2 + b s + K e^(-s tau).
inline double stiffest_behind_delay(const WallDevice& device, Seconds lag) {
  assert(lag.value > 0);
  const double ratio = device.damping * lag.value / device.mass;
  if (ratio <= 0) return 0;
  const double phi = root_between(0, 0.5 * std::numbers::pi,
                                  [&](double x) { return x * std::sin(x) - ratio * std::cos(x); });
  return device.damping / lag.value * phi / std::sin(phi);
}

/// K = b (1 - p) / ((1 - p) m / b - p T), p = e^(-b T / m): sampled and held without any other delay, B = 0;
/// exact. Near 2 b / T for b T / m << 1. From the product of the two roots, which is 1 at the border.
inline double stiffest_undelayed(const WallDevice& device, Hertz rate) {
  // The formula's differences, without their cancellation: see HeldMass.
  const auto held = HeldMass::over(device.mass, device.damping, 1 / rate.value);
  const double lost = -std::expm1(-device.damping / (device.mass * rate.value));
  return lost / (held.reach * held.gain - held.keep * held.rise);
}

/// What goes on for ever around one edge of the encoder.
struct EdgeCycle {
  Hertz frequency;
  double counts;  ///< amplitude over Delta
};
/// A hand leans on the wall with half of K Delta, so that the force jumps between +M and -M, M = K Delta / 2,
/// each tau = T/2 + tau_d after the device crosses the edge: a relay behind a delay on 1 / (s (m s + b)).
/// With a = b/m, from one jump to the next (h = half a period)
///     v0 = -(M/b) tanh(a h / 2),   x0 = -((M/b) h + (v0 - M/b) (1 - e^-ah) / a) / 2,
///     x(t) = x0 + (M/b) t + (v0 - M/b) (1 - e^-at) / a,   x(h - tau) = 0.
/// Exact for T << tau and the passage over one edge only, counts < 1/2. Nothing where f_c >= M. Needs b > 0
/// and Delta > 0. Tsypkin, "Relay control systems", 1984, chapter 4.
inline std::optional<EdgeCycle> encoder_edge_cycle(const WallDevice& device, double stiffness, Seconds lag) {
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

/// Speed after a bounce over the speed before, of a device without damping:
///     e = exp((pi w tau / 2) / sqrt(1 - (w tau / 2)^2)),  w = sqrt(K/m), tau = T/2 + tau_d.
/// The delay acts as a damper of -K tau. Within 1 % for w tau <= 0.2; needs w tau < 2.
inline double wall_rebound(double mass, double stiffness, Seconds lag) {
  const double half = 0.5 * std::sqrt(stiffness / mass) * lag.value;
  assert(half < 1);
  return std::exp(std::numbers::pi * half / std::sqrt(1 - half * half));
}

/// Amplitude [m] at which a spring above its border comes to rest in a limit cycle, its force cut at F_max:
/// where the describing function of the cut, with r = amplitude K / F_max,
///     K (2/pi) (asin(1/r) + sqrt(1 - 1/r^2) / r) = K_border.
/// Needs 0 < border < stiffness and a finite limit. Too small by what it leaves out of the harmonics: 1 %
/// just above the border, 12 % far above it, where the force is a square wave (encoder_edge_cycle with M =
/// F_max is exact there). Gelb & Vander Velde, "Multiple-input describing functions", 1968, section 2.3.
inline double cut_cycle_amplitude(double stiffness, double border, double force_limit) {
  assert(border > 0 && border < stiffness && std::isfinite(force_limit));
  // Over s = 1/r, from 0 (all cut) to 1 (nothing cut): the share of the stiffness that is left rises.
  const auto left = [](double s) { return 2 / std::numbers::pi * (std::asin(s) + s * std::sqrt(1 - s * s)); };
  const double s = root_between(0, 1, [&](double x) { return left(x) - border / stiffness; });
  return force_limit / (stiffness * s);
}

/// Largest |root| of the same loop with the stiffness K, by the eigenvalues of the companion
/// matrix: below 1 it is stable. Time in proportion to the cube of the frames of delay; at most 1000 of them.
inline double largest_root(const WallDevice& device, const WallLoop& loop, double stiffness) {
  using Polynomial = std::vector<double>;  // the constant first
  const auto product = [](const Polynomial& a, const Polynomial& b) {
    Polynomial result(a.size() + b.size() - 1, 0.0);
    for (std::size_t i = 0; i < a.size(); ++i)
      for (std::size_t j = 0; j < b.size(); ++j) result[i + j] += a[i] * b[j];
    return result;
  };
  const SplitDelay delay{loop.delay, loop.rate};
  assert(delay.whole <= 1000);
  const double first = delay.fraction * loop.period();
  const auto whole = HeldMass::over(device.mass, device.damping, loop.period());
  const auto early = HeldMass::over(device.mass, device.damping, first);
  const auto late = HeldMass::over(device.mass, device.damping, loop.period() - first);
  // 1 + (K + B (1 - z^-1) / T) G(z) times (z - 1) (z - p) z^(d + 2).
  auto top = product({-whole.keep, 1}, {early.rise + late.reach * early.gain, late.rise});
  top[0] += whole.reach * late.keep * early.gain;
  top[1] += whole.reach * late.gain;
  const double virtual_damping = loop.damping * loop.rate.value;
  const auto pushed = product(top, {-virtual_damping, stiffness + virtual_damping});
  Polynomial sum(static_cast<std::size_t>(delay.whole) + 5, 0.0);
  const auto poles = product({-1, 1}, {-whole.keep, 1});
  std::copy(poles.begin(), poles.end(), sum.end() - 3);
  for (std::size_t i = 0; i < pushed.size(); ++i) sum[i] += pushed[i];
  const auto degree = static_cast<Eigen::Index>(sum.size()) - 1;
  Eigen::MatrixXd companion = Eigen::MatrixXd::Zero(degree, degree);
  companion.diagonal(-1).setOnes();
  for (Eigen::Index i = 0; i < degree; ++i)
    companion(i, degree - 1) = -sum[static_cast<std::size_t>(i)] / sum.back();
  return Eigen::EigenSolver<Eigen::MatrixXd>{companion, false}.eigenvalues().cwiseAbs().maxCoeff();
}

}  // namespace tactus::test
