#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "engine/physics/network.h"

using namespace tactus;

namespace {

/// A stick of 12.5 g under 0.6 N (48 m/s^2) on a hard fixed head of restitution 0.6; each time that it has
/// left the head, an impulse throws it after a delay. The map of rebound speeds is exact for short contacts
/// and pulses:
///   v+ = e sqrt(v^2 + D^2 + 2 D (v - a t)),  D = impulse / mass.
constexpr double kMass = 0.0125, kForce = 0.6, kAcceleration = kForce / kMass, kRestitution = 0.6,
                 kRate = 192e3;

double fixed_point(double throw_speed, double delay) {
  const double q = 1 / (kRestitution * kRestitution) - 1;
  return (throw_speed +
          std::sqrt(throw_speed * throw_speed +
                    q * (throw_speed * throw_speed - 2 * throw_speed * kAcceleration * delay))) /
         q;
}

struct Roll {
  double interval = 0;  // mean of the last ten
  double speed = 0;     // of the last rebound, before the pulse
  bool died = false;    // it was back before the throw came
};

Roll roll(double throw_speed, double delay, double start_speed, double seconds) {
  NetworkElements elements;
  elements.points = {{Point::Kind::Mass, kMass, 1e-6, start_speed, {}}, {Point::Kind::Ground, 0, 0, 0, {}}};
  // So stiff that a contact lasts 60 us and the stick is thrown where it left.
  elements.contacts = {
      {.lower = 1, .upper = 0, .stiffness = 5e9, .exponent = 1.5, .restitution = kRestitution}};
  elements.forces = {{0, {0, {}}}};
  const auto network = Network::make(elements, 1, Hertz{kRate}, Solver::Passive, 4).value();
  auto state = network.initial_state();
  Roll result;
  std::vector<double> exits;
  const int wait = static_cast<int>(std::lround(delay * kRate));
  int pulse = wait;  // frames until the throw
  bool touching = false;
  for (int n = 0; n < seconds * kRate; ++n) {
    const bool now = network.indentation(state, 0) > 0.0;
    if (touching && !now) {
      exits.push_back(n / kRate);
      result.speed = network.velocity(state, 0);
      pulse = wait;
    }
    if (!touching && now && pulse > 0) result.died = true;
    touching = now;
    const double force = -kForce + (pulse-- == 0 ? throw_speed * kMass * kRate : 0.0);
    network.step(state, &force);
  }
  if (exits.size() > 11) result.interval = (exits.back() - exits[exits.size() - 11]) / 10;
  return result;
}

}  // namespace

TEST_CASE("roll: impulses that throw the stick make the roll of the impulse map", "[physics]") {
  struct Case {
    double throw_speed, delay, speed, rate;
  };
  const auto c =
      GENERATE(Case{0.5, 0.0, 0.75, 19.20}, Case{0.5, 5e-3, 0.57233, 23.69}, Case{1.5, 20e-3, 1.4417, 8.98});
  CHECK(fixed_point(c.throw_speed, c.delay) == Approx(c.speed).epsilon(1e-4));
  const auto r = roll(c.throw_speed, c.delay, 1.2 * c.speed, 4.0);
  CHECK(1.0 / r.interval == Approx(c.rate).epsilon(0.01));
  CHECK(r.speed == Approx(c.speed).epsilon(0.01));
}

TEST_CASE("roll: it dies when the throw comes later than D / (2 a (1 - e^2))", "[physics]") {
  const double throw_speed = GENERATE(0.5, 1.5);
  const double limit = throw_speed / (2 * kAcceleration * (1 - kRestitution * kRestitution));
  CHECK(roll(throw_speed, 0.95 * limit, 2.0 * throw_speed, 4.0).died == false);
  CHECK(roll(throw_speed, 1.05 * limit, 2.0 * throw_speed, 4.0).died);
}
