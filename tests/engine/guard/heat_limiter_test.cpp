#include "engine/guard/heat_limiter.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "engine/core/units.h"
#include "engine/guard/drive_guard.h"

using namespace tactus;

namespace {

constexpr Hertz kRate = 48_kHz;

/// The equations of heat.h by Runge and Kutta's fourth-order method, `steps` to a frame.
class FineHeat {
 public:
  explicit FineHeat(const HeatLimits& limits) : limits_(limits) {}
  void frame(double y, int steps = 1) {
    const double p = y * y * limits_.watts_at_full_scale / limits_.watts_for_ever;
    const double h = 1.0 / kRate.value / steps;
    for (int n = 0; n < steps; ++n) {
      const auto k1 = slope(state, p), k2 = slope(state + 0.5 * h * k1, p),
                 k3 = slope(state + 0.5 * h * k2, p), k4 = slope(state + h * k3, p);
      state = state + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
    }
  }
  Vector2 state;

 private:
  Vector2 slope(Vector2 t, double p) const {
    const double s = limits_.coil_share;
    return {(s * p - (t.x - t.y)) / limits_.coil_time.value,
            ((1 - s) / s * (t.x - t.y) - t.y) / limits_.body_time.value};
  }
  HeatLimits limits_;
};

HeatLimits random_limits(std::mt19937& random) {
  const auto between = [&](double low, double high) {
    return low * std::pow(high / low, std::uniform_real_distribution<double>{0, 1}(random));
  };
  HeatLimits limits;
  limits.watts_for_ever = between(0.1, 200);
  limits.watts_at_full_scale = limits.watts_for_ever * between(0.3, 20);
  limits.coil_time = Seconds{between(0.2, 20)};
  limits.body_time = Seconds{between(1, 2000)};
  limits.coil_share = between(0.1, 0.9);
  limits.rise_kelvin = between(30, 200);
  return limits;
}

/// What haptic drives look like: tone, pulses, noise, held force, sweep, in turns of a quarter of a second.
double signal(int kind, int n, std::mt19937& random) {
  const double t = n / kRate.value;
  switch ((kind + n / 12'000) % 5) {
    case 0:
      return 0.9 * std::sin(2 * kPi * 37 * t);
    case 1:
      return std::exp(-std::fmod(t, 0.06) / 0.006);
    case 2:
      return std::uniform_real_distribution<double>{-1, 1}(random);
    case 3:
      return 0.7;
    default:
      return std::sin(2 * kPi * (20 + 200 * t) * t);
  }
}

}  // namespace

TEST_CASE("heat: within 1 degree of a fine integration, for 50 random actuators and real signals", "[core]") {
  std::mt19937 random{11};
  double worst_kelvin = 0.0, warmest_share = 0.0, most_held_back = 0.0;
  for (int profile = 0; profile < 50; ++profile) {
    const auto limits = random_limits(random);
    DriveGuard guard{DriveGuard::Kind::Drive, {.heat = limits}, kRate};
    guard.set_open(true, 0);
    FineHeat fine{limits};
    REQUIRE(check({.heat = limits}));
    std::vector<double> block(kGuardGroup);  // the model moves on at the ends of groups
    for (int n = 0; n < 96'000; n += kGuardGroup) {
      for (int k = 0; k < kGuardGroup; ++k)
        block[static_cast<std::size_t>(k)] = signal(profile, n + k, random);
      guard.process(block.data(), kGuardGroup, n);
      for (const double y : block) fine.frame(y);
      const auto state = guard.thermal_state();
      worst_kelvin = std::max({worst_kelvin, limits.rise_kelvin * std::abs(state.coil - fine.state.x),
                               limits.rise_kelvin * std::abs(state.body - fine.state.y)});
      warmest_share = std::max(warmest_share, fine.state.x);
    }
    most_held_back = std::max(most_held_back, guard.counts()[GuardStage::Heat].most);
  }
  INFO("largest difference " << worst_kelvin << " K, warmest " << warmest_share << " of the limit");
  CHECK(worst_kelvin < 1.0);
  CHECK(warmest_share < 1.0);
  CHECK(warmest_share > 0.9);
  CHECK(most_held_back > 0.3);
}

TEST_CASE("heat: a steady power settles where the equations say", "[core]") {
  // p = 0.6 in the long run: coil 0.6, body 0.6 (1 - s). Nothing is held back below 0.8.
  const HeatLimits limits{.watts_at_full_scale = 6,
                          .watts_for_ever = 10,
                          .coil_time = 50_ms,
                          .body_time = 500_ms,
                          .coil_share = 0.25};
  DriveGuard guard{DriveGuard::Kind::Drive, {.heat = limits}, kRate};
  guard.set_open(true, 0);
  std::vector<double> block(48'000, 1.0);
  for (int second = 0; second < 20; ++second) guard.process(block.data(), 48'000, 48'000 * second);
  CHECK(guard.thermal_state().coil == Approx(0.6).epsilon(1e-9));
  CHECK(guard.thermal_state().body == Approx(0.45).epsilon(1e-9));
  CHECK(guard.counts() == GuardCounts{});
}

TEST_CASE("heat: counts power and not force", "[core]") {
  const HeatLimits limits{.watts_at_full_scale = 6, .watts_for_ever = 10, .coil_time = 50_ms};
  const auto warmth = [&](double y, double turn) {
    DriveGuard guard{DriveGuard::Kind::Drive, {.heat = limits}, kRate};
    guard.set_open(true, 0);
    for (int n = 0; n < 6400; ++n) {
      double sample = n % 2 == 0 ? y : turn * y;
      guard.process(&sample, 1, n);
    }
    return guard.thermal_state().coil;
  };
  CHECK(warmth(0.8, 1.0) == warmth(0.8, -1.0));
  CHECK(warmth(0.8, 1.0) == Approx(4.0 * warmth(0.4, 1.0)).epsilon(1e-12));
}

TEST_CASE("heat: what is restored is never cooler than it was", "[core]") {
  const HeatLimits limits{.watts_at_full_scale = 6, .watts_for_ever = 10};
  HeatLimiter heat{limits, 1.0, std::numeric_limits<double>::infinity(), kRate};
  heat.warm_to({0.5, 0.2});
  heat.warm_to({0.1, 0.4});
  CHECK(heat.state() == ThermalState{0.5, 0.4});
  CHECK(heat.gain().idle());
  heat.warm_to({1.0, 1.0 - limits.coil_share});
  CHECK(heat.gain().now() == 0.0);
}

TEST_CASE("heat: cools as a fine integration does while it is off", "[core]") {
  const HeatLimits limits{
      .watts_at_full_scale = 6, .watts_for_ever = 10, .coil_time = 300_ms, .body_time = 2_s};
  FineHeat fine{limits};
  fine.state = {0.9, 0.5};
  for (int n = 0; n < 48'000; ++n) fine.frame(0.0);
  HeatLimiter heat{limits, 1.0, std::numeric_limits<double>::infinity(), kRate};
  heat.warm_to({0.9, 0.5});
  for (int n = 0; n < 48'000; n += kGuardGroup) heat.end_group();
  const auto after = heat.state();
  CHECK(after.coil == Approx(fine.state.x).epsilon(1e-9));
  CHECK(after.body == Approx(fine.state.y).epsilon(1e-9));
}
