#include "engine/study/orbits/bouncing_ball.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "engine/core/find_root.h"
#include "engine/core/units.h"

namespace tactus {
namespace {
constexpr double kInstant = 1e-14;
// Of g/w: the bounces that remain take less than 1e-12 of a period.
constexpr double kSticks = 1e-12;

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
  const double phase = from.phase + time, turn = 2.0 * kPi * std::floor(phase / (2.0 * kPi));
  for (const double next : {turn + up, turn + down, turn + up + 2.0 * kPi})
    if (next - from.phase > time + kInstant) return next - from.phase;
  return turn + down + 2.0 * kPi - from.phase;
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
      if (height(from, until) <= 0.0) {
        const auto landing = find_zero(above, start, until, kInstant);
        return landing.near;
      }
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
    leaves.phase += std::fmod(std::fmod(up - from.phase, 2.0 * kPi) + 2.0 * kPi, 2.0 * kPi);
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

}  // namespace tactus
