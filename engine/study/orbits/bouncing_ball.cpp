#include "engine/study/orbits/bouncing_ball.h"

#include <algorithm>
#include <cmath>

#include "engine/core/find_root.h"
#include "engine/core/units.h"

namespace tactus {
namespace {

using Bounce = BouncingBall::Bounce;

constexpr double kTurn = 2.0 * kPi;
constexpr double kInstant = 1e-14;
// Of g/w: the bounces that remain take less than 1e-12 of a period.
constexpr double kSticks = 1e-12;
constexpr double kShrinks = 4.669;  // Feigenbaum's constant: about what the next interval is
constexpr int kSettling = 40'000;   // bounces

/// An orbit that closes after some bounces.
struct ClosedOrbit {
  Bounce bounce;
  Matrix2 jacobian;  ///< of all its bounces together
  bool found = false;

  /// Falls through 0 where the orbit doubles its period: det(J + 1), zero for a multiplier of -1.
  double before_doubling() const {
    const auto& j = jacobian;
    return 1.0 + (j.a + j.d) + (j.a * j.d - j.b * j.c);
  }
};

/// By Newton's method from near it: the orbit that closes after `bounces` bounces and `mode * bounces`
/// periods of the table.
ClosedOrbit close_orbit(const BouncingBall& ball, int mode, int bounces, const Bounce& near) {
  const double round = kTurn * mode * bounces;
  auto start = near;
  for (int i = 0; i < 30; ++i) {
    BouncingBall::Linearised end{start, {1, 0, 0, 1}};
    for (int n = 0; n < bounces; ++n) {
      const auto step = ball.next_linearised(end.bounce);
      end = {step.bounce, step.jacobian * end.jacobian};
    }
    const double phase = end.bounce.phase - start.phase - round, speed = end.bounce.speed - start.speed;
    if (std::hypot(phase, speed) < 1e-11 * bounces) return {start, end.jacobian, true};
    // (1 - J) d = residual
    const auto& j = end.jacobian;
    const double a = 1.0 - j.a, d = 1.0 - j.d, det = a * d - j.b * j.c;
    start.phase += (d * phase + j.b * speed) / det;
    start.speed += (j.c * phase + a * speed) / det;
    if (!(std::hypot(start.phase - near.phase, start.speed - near.speed) < 1.0)) break;
  }
  return {near, {1, 0, 0, 1}};
}

/// The attractor near `from`.
Bounce settle(const BouncingBall& ball, int bounces, Bounce from) {
  for (int i = 0; i < kSettling / bounces * bounces; ++i) from = ball.next(from);
  from.phase = std::remainder(from.phase, kTurn);
  return from;
}

}  // namespace

double BouncingBall::orbit_begins(int mode, double e) { return mode * kPi * (1.0 - e) / (1.0 + e); }

double BouncingBall::orbit_doubles(int mode, double e) {
  return std::hypot(orbit_begins(mode, e), 2.0 * (1.0 + e * e) / ((1.0 + e) * (1.0 + e)));
}

BouncingBall::Bounce BouncingBall::orbit(int mode) const {
  return {std::acos(orbit_begins(mode, restitution_) / drive_), mode * kPi};
}

/// Above the table.
double BouncingBall::height(const Bounce& from, double time) const {
  return drive_ * (std::sin(from.phase) - std::sin(from.phase + time)) + time * (from.speed - 0.5 * time);
}

double BouncingBall::rise(const Bounce& from, double time) const {
  return from.speed - time - drive_ * std::cos(from.phase + time);
}

/// Where the height's bend, Gamma sin(theta) - 1, changes its sign next.
double BouncingBall::next_bend(const Bounce& from, double time) const {
  if (drive_ <= 1.0) return std::max(2.0 * time, 1.0);  // bent down always: any place will do
  const double up = std::asin(1.0 / drive_), down = kPi - up;
  const double phase = from.phase + time, turn = kTurn * std::floor(phase / kTurn);
  for (const double next : {turn + up, turn + down, turn + up + kTurn})
    if (next - from.phase > time + kInstant) return next - from.phase;
  return turn + down + kTurn - from.phase;
}

/// Between two bends the rise is monotone, and between its zeros the height is: no landing is missed.
double BouncingBall::flight(const Bounce& from) const {
  double start = 0.0;
  while (true) {
    const double end = next_bend(from, start);
    double ends[2] = {end, end};
    const double first = rise(from, start), last = rise(from, end);
    if ((first < 0.0) != (last < 0.0) && first != 0.0)
      ends[0] = find_zero([&](double t) { return rise(from, t); }, start, end, kInstant).near;
    for (const double until : ends) {
      const auto above = [&](double t) { return t == 0.0 ? 1e-300 : height(from, t); };
      if (height(from, until) <= 0.0) return find_zero(above, start, until, kInstant).near;
      start = until;
    }
  }
}

BouncingBall::Bounce BouncingBall::land(const Bounce& from, double time) const {
  const double phase = from.phase + time, table = drive_ * std::cos(phase);
  return {phase, table + restitution_ * (table - (from.speed - time))};
}

BouncingBall::Bounce BouncingBall::next(const Bounce& from) const {
  if (from.resting) return from;
  auto leaves = from;
  const double table = drive_ * std::cos(from.phase);
  if (from.speed - table < kSticks && drive_ * std::sin(from.phase) < 1.0) {
    if (drive_ <= 1.0) return {from.phase, table, true};
    const double up = std::asin(1.0 / drive_);
    leaves.phase += std::fmod(std::fmod(up - from.phase, kTurn) + kTurn, kTurn);
    leaves.speed = drive_ * std::cos(leaves.phase);
  }
  return land(leaves, flight(leaves));
}

BouncingBall::Linearised BouncingBall::next_linearised(const Bounce& from) const {
  const double t = flight(from), phase = from.phase + t, e = restitution_;
  // The height at landing stays 0:  F_theta + F_T dT/dtheta = 0,  F_V + F_T dT/dV = 0.
  const double falls = rise(from, t);
  const double by_phase = -drive_ * (std::cos(from.phase) - std::cos(phase)) / falls;
  const double by_speed = -t / falls;
  const double kick = (1.0 + e) * drive_ * std::sin(phase);
  return {land(from, t),
          {1.0 + by_phase, by_speed, e * by_phase - kick * (1.0 + by_phase),
           -e + e * by_speed - kick * by_speed}};
}

std::vector<double> period_doublings(int mode, double restitution, int count) {
  double drive = BouncingBall::orbit_begins(mode, restitution);
  double interval = BouncingBall::orbit_doubles(mode, restitution) - drive;
  drive += 0.01 * interval;
  auto near = BouncingBall{drive, restitution}.orbit(mode);
  std::vector<double> doublings;
  for (int bounces = 1; static_cast<int>(doublings.size()) < count; bounces *= 2) {
    const auto at = [&](double d) { return close_orbit({d, restitution}, mode, bounces, near); };
    // Follows the orbit in small steps to its doubling.
    const double step = 0.05 * interval;
    auto orbit = at(drive);
    while (orbit.found && orbit.before_doubling() > 0.0) {
      near = orbit.bounce;
      orbit = at(drive += step);
    }
    if (!orbit.found) break;
    const double found =
        find_zero([&](double d) { return at(d).before_doubling(); }, drive - step, drive, 1e-13).near;
    interval = doublings.empty() ? 0.1 * found : (found - doublings.back()) / kShrinks;
    doublings.push_back(found);
    // Far enough behind it for the doubled orbit to be apart, near enough for it to be stable.
    drive = found + 0.2 * interval;
    near.phase += 1e-3 * std::sqrt(interval);
    near = settle({drive, restitution}, 2 * bounces, near);
  }
  return doublings;
}

}  // namespace tactus
