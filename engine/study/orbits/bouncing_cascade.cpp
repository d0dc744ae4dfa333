#include "engine/study/orbits/bouncing_cascade.h"

#include <cmath>
#include <numbers>

#include "engine/core/find_root.h"

namespace tactus {
namespace {

using Bounce = BouncingBall::Bounce;

constexpr double kShrinks = 4.669;  // Feigenbaum's constant: about what the next interval is
constexpr int kSettling = 40'000;   // bounces

/// Where the ball is after `bounces`, and how that depends on where it started.
ClosedOrbit go_round(const BouncingBall& ball, int bounces, const Bounce& from) {
  ClosedOrbit orbit{from, {1, 0, 0, 1}};
  for (int i = 0; i < bounces; ++i) {
    const auto step = ball.next_linearised(orbit.bounce);
    orbit.jacobian = step.jacobian * orbit.jacobian;
    orbit.bounce = step.bounce;
  }
  return orbit;
}

/// The attractor near `from`.
Bounce settle(const BouncingBall& ball, int bounces, Bounce from) {
  for (int i = 0; i < kSettling / bounces * bounces; ++i) from = ball.next(from);
  from.phase = std::remainder(from.phase, 2.0 * std::numbers::pi);
  return from;
}

class Cascade {
 public:
  Cascade(int mode, double restitution) : mode_(mode), restitution_(restitution) {}

  /// Follows the orbit of `bounces` from `drive` in steps of `step` to its doubling; 0 if it is lost.
  double follow(int bounces, double drive, double step, Bounce& near) const {
    auto orbit = at(bounces, drive, near);
    while (orbit.found && orbit.before_doubling() > 0.0) {
      near = orbit.bounce;
      orbit = at(bounces, drive += step, near);
    }
    if (!orbit.found) return 0.0;
    const auto left = [&](double d) { return at(bounces, d, near).before_doubling(); };
    return find_zero(left, drive - step, drive, 1e-13).near;
  }

  BouncingBall ball(double drive) const { return {drive, restitution_}; }

 private:
  ClosedOrbit at(int bounces, double drive, const Bounce& near) const {
    return close_orbit(ball(drive), mode_, bounces, near);
  }

  int mode_;
  double restitution_;
};

}  // namespace

double ClosedOrbit::before_doubling() const {
  const auto& j = jacobian;
  return 1.0 + (j.a + j.d) + (j.a * j.d - j.b * j.c);
}

bool ClosedOrbit::stable() const {
  const double trace = jacobian.a + jacobian.d, det = jacobian.a * jacobian.d - jacobian.b * jacobian.c;
  return std::abs(trace) < 1.0 + det && det < 1.0;
}

ClosedOrbit close_orbit(const BouncingBall& ball, int mode, int bounces, const Bounce& near) {
  const double round = 2.0 * std::numbers::pi * mode * bounces;
  auto start = near;
  for (int i = 0; i < 30; ++i) {
    auto end = go_round(ball, bounces, start);
    const double phase = end.bounce.phase - start.phase - round, speed = end.bounce.speed - start.speed;
    if (std::hypot(phase, speed) < 1e-11 * bounces) return {start, end.jacobian, true};
    // (1 - J) d = residual
    const auto& j = end.jacobian;
    const double a = 1.0 - j.a, d = 1.0 - j.d, det = a * d - j.b * j.c;
    start.phase += (d * phase + j.b * speed) / det;
    start.speed += (j.c * phase + a * speed) / det;
    if (!(std::hypot(start.phase - near.phase, start.speed - near.speed) < 1.0)) break;
  }
  return {near, {1, 0, 0, 1}, false};
}

std::vector<double> period_doublings(int mode, double restitution, int count) {
  const Cascade cascade(mode, restitution);
  double drive = BouncingBall::orbit_begins(mode, restitution);
  double interval = BouncingBall::orbit_doubles(mode, restitution) - drive;
  drive += 0.01 * interval;
  auto near = cascade.ball(drive).orbit(mode);
  std::vector<double> doublings;
  for (int bounces = 1; static_cast<int>(doublings.size()) < count; bounces *= 2) {
    const double found = cascade.follow(bounces, drive, 0.05 * interval, near);
    if (found == 0.0) break;
    if (!doublings.empty()) interval = (found - doublings.back()) / kShrinks;
    if (doublings.empty()) interval = 0.1 * found;
    doublings.push_back(found);
    // Far enough behind it for the doubled orbit to be apart, near enough for it to be stable.
    drive = found + 0.2 * interval;
    near.phase += 1e-3 * std::sqrt(interval);
    near = settle(cascade.ball(drive), 2 * bounces, near);
  }
  return doublings;
}

}  // namespace tactus
