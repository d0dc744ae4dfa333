#include "engine/study/walls/virtual_wall.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <optional>
#include <vector>

#include "engine/core/find_root.h"

namespace tactus {
namespace {

using Complex = std::complex<double>;

/// The numbers of G(z).
struct SampledDevice {
  SampledDevice(const WallDevice& device, const WallLoop& loop) : delay(loop.delay, loop.rate) {
    const double period = loop.period(), first = delay.fraction * period;
    const auto whole = HeldMass::over(device.mass, device.damping, period);
    const auto early = HeldMass::over(device.mass, device.damping, first);
    const auto late = HeldMass::over(device.mass, device.damping, period - first);
    lost = -std::expm1(-device.damping * period / device.mass);
    reach = whole.reach;
    h1 = early.rise + late.reach * early.gain;
    g1 = late.keep * early.gain;
    h2 = late.rise;
    g2 = late.gain;
  }

  /// G at e^jt; small angles lose no digits.
  Complex at(double t) const {
    const Complex back = std::polar(1.0, -t);
    const Complex step = Complex{0, 2 * std::sin(0.5 * t)} * std::polar(1.0, 0.5 * t);  // z - 1
    const Complex decay = step + lost;                                                  // z - p
    const Complex top = decay * (h1 * back + h2) + reach * (g1 * back + g2);
    return std::polar(1.0, -t * delay.whole) * top / (step * decay);
  }

  SplitDelay delay;
  double lost, reach, h1, h2, g1, g2;
};

/// Angles that show every sign change of a curve which turns with the delay: evenly on the logarithm, where
/// slow devices cross, and evenly.
std::vector<double> grid_of(double frames_of_delay) {
  constexpr double kLowest = 1e-8;
  constexpr int kPerDecade = 100;
  std::vector<double> grid;
  const double spacing = kPi / (8 * (frames_of_delay + 2));
  for (int i = 0; kLowest * std::pow(10.0, static_cast<double>(i) / kPerDecade) < spacing; ++i)
    grid.push_back(kLowest * std::pow(10.0, static_cast<double>(i) / kPerDecade));
  for (int i = 1; i * spacing < kPi * (1 - 1e-12); ++i) grid.push_back(i * spacing);
  grid.push_back(kPi);
  return grid;
}

struct Crossing {
  double value, angle;
};

/// The smallest positive value of `curve` on the real axis. At t = pi it is always real.
template <class Curve>
std::optional<Crossing> smallest_crossing(const Curve& curve, const std::vector<double>& grid) {
  std::optional<Crossing> least;
  const auto offer = [&](double angle) {
    const double value = curve(angle).real();
    if (value > 0 && (!least || value < least->value)) least = {value, angle};
  };
  Complex before = curve(grid.front());
  for (std::size_t i = 1; i + 1 < grid.size(); ++i) {
    const Complex now = curve(grid[i]);
    const bool crosses = (before.imag() > 0) != (now.imag() > 0);
    // |curve| grows with the angle: beyond twice the best angle there is nothing to find.
    const bool near = !least || std::min(std::abs(before), std::abs(now)) < 2 * least->value;
    if (crosses && near) offer(root_between(grid[i - 1], grid[i], [&](double t) { return curve(t).imag(); }));
    before = now;
  }
  offer(grid.back());
  return least;
}

}  // namespace

double stiffest_by_damping(const WallDevice& device, const WallLoop& loop) {
  return std::max(0.0, device.damping + loop.damping) / loop.lag();
}

double stiffest_passive(const WallDevice& device, const WallLoop& loop) {
  return std::max(0.0, device.damping - std::abs(loop.damping)) / loop.lag();
}

double stiffest_by_friction(const WallDevice& device) {
  return device.quantum > 0 ? 2 * device.friction / device.quantum : std::numeric_limits<double>::infinity();
}

WallBorder wall_border(const WallDevice& device, const WallLoop& loop) {
  if (device.damping + loop.damping <= 0) return {};
  const SampledDevice sampled{device, loop};
  const auto grid = grid_of(sampled.delay.whole);
  const auto backward = [](double t) { return 1.0 - std::polar(1.0, -t); };
  const double per_second = loop.rate.value;
  if (loop.damping != 0) {
    const auto by_damping = [&](double t) { return -1.0 / (sampled.at(t) * backward(t) * per_second); };
    const auto largest_damping = smallest_crossing(by_damping, grid);
    if (largest_damping && loop.damping >= largest_damping->value) return {};
  }
  const auto by_stiffness = [&](double t) {
    return -1.0 / sampled.at(t) - loop.damping * per_second * backward(t);
  };
  const auto least = smallest_crossing(by_stiffness, grid);
  if (!least) return {};
  return {least->value, Hertz{least->angle * per_second / (2 * kPi)}};
}

}  // namespace tactus
