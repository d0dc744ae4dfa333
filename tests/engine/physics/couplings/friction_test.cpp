#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "engine/core/units.h"
#include "engine/physics/network.h"
#include "tests/engine/physics/energy_audit.h"

using namespace tactus;

namespace {

Point mass(double kilogram, double position = 0.0, double velocity = 0.0) {
  return {Point::Kind::Mass, kilogram, position, velocity, {}};
}
Point ground() { return {Point::Kind::Ground, 0, 0, 0, {}}; }

Friction coulomb(int lower, int upper, double mu, int normal) {
  Friction friction{.lower = lower, .upper = upper, .law = {}, .normal = {normal, {}}};
  friction.law.kinetic = mu;
  return friction;
}

Solver any_solver() { return GENERATE(Solver::Passive, Solver::Explicit, Solver::Implicit, Solver::Exact); }

}  // namespace

TEST_CASE("friction: a sliding block stops after v^2 / (2 mu N / m), and stays", "[physics]") {
  const auto solver = any_solver();
  CAPTURE(static_cast<int>(solver));
  NetworkElements elements;
  elements.points = {mass(0.5, 0.0, 2.0), ground()};
  elements.frictions = {coulomb(0, 1, 0.3, 0)};
  const auto network = Network::make(elements, 1, 10_kHz, solver, 1).value();
  auto state = network.initial_state();
  const double normal = 4.0;
  for (int n = 0; n < 20000; ++n) network.step(state, &normal);
  // 2.4 m/s^2: 0.8333 m in 0.8333 s. The first frame's normal force begins half a frame late where inputs are
  // centred, 0.1 mm; the explicit solver is as exact.
  CHECK(network.position(state, 0) == Approx(4.0 / (2 * 2.4)).margin(2e-4));
  CHECK(network.velocity(state, 0) == Approx(0.0).margin(1e-12));
  const double before = network.position(state, 0);
  for (int n = 0; n < 1000; ++n) network.step(state, &normal);
  CHECK(network.position(state, 0) == Approx(before).margin(1e-12));
}

TEST_CASE("friction: what pushes less than mu N is held, what pushes more slides at (F - mu N) / m",
          "[physics]") {
  const auto solver = any_solver();
  const auto push = GENERATE(-1.19, 1.19, 1.21, -1.3);
  CAPTURE(static_cast<int>(solver), push);
  NetworkElements elements;
  elements.points = {mass(0.5), ground()};
  elements.frictions = {coulomb(0, 1, 0.3, 0)};
  elements.forces = {{0, {1, {}}}};
  const auto network = Network::make(elements, 2, 10_kHz, solver, 1).value();
  auto state = network.initial_state();
  const double inputs[] = {4.0, push};
  for (int n = 0; n < 10000; ++n) network.step(state, inputs);
  const double net = std::max(0.0, std::abs(push) - 1.2) * (push < 0 ? -1.0 : 1.0);
  CHECK(network.position(state, 0) == Approx(net / 0.5 / 2).margin(2e-4 * std::abs(net / 0.5)).epsilon(0));
  CHECK(network.friction_force(state, 0) == Approx(net == 0.0 ? push : std::copysign(1.2, push)));
}

TEST_CASE("friction: a spring and a mass lose 4 mu N / k of their swing in each period", "[physics]") {
  const auto solver = any_solver();
  CAPTURE(static_cast<int>(solver));
  const double k = 200.0, m = 0.05, mu = 0.2, normal = 1.0;
  NetworkElements elements;
  elements.points = {mass(m, 0.05), ground()};
  elements.springs = {{1, 0, k, 0.0, 0.0}};
  elements.frictions = {coulomb(0, 1, mu, 0)};
  const auto network = Network::make(elements, 1, 48_kHz, solver, 1).value();
  auto state = network.initial_state();
  const double period = 2 * kPi * std::sqrt(m / k) * 48e3;
  double swing = 0.05;
  for (int cycle = 0; cycle < 5; ++cycle) {
    double highest = -1.0;
    for (int n = 0; n < static_cast<int>(std::lround(period * (cycle + 1))) -
                            static_cast<int>(std::lround(period * cycle));
         ++n) {
      network.step(state, &normal);
      if (n > period / 2) highest = std::max(highest, network.position(state, 0));
    }
    swing -= 4 * mu * normal / k;
    CHECK(highest == Approx(swing).epsilon(1e-3));
  }
}

TEST_CASE("friction: the period of stick and slip on a moving belt", "[physics]") {
  // Holds while the spring is drawn from Fk - (Fs - Fk) to Fs, then swings back about Fk:
  //   T = 2 (Fs - Fk) / (k v) + (2 / w) (pi - atan((Fs - Fk) w / (k v))).
  // The coefficient falls within 0.1 mm/s, which is nothing against the slip's 0.2 m/s.
  const auto solver = any_solver();
  CAPTURE(static_cast<int>(solver));
  const double k = 1000.0, m = 0.1, speed = 0.02, normal = 10.0;
  Friction friction = coulomb(2, 0, 0.3, 1);
  friction.law.drops[0] = {0.1, 1e-4};
  NetworkElements elements;
  elements.points = {mass(m), ground(), {Point::Kind::Motion, 0, 0, 0, {0, {}}}};
  elements.springs = {{1, 0, k, 0.0, 0.0}};
  elements.frictions = {friction};
  const auto network = Network::make(elements, 2, 48_kHz, solver, 1).value();
  auto state = network.initial_state();
  const double w = std::sqrt(k / m), d = 0.1 * normal;
  const double expected = 2 * d / (k * speed) + 2 / w * (kPi - std::atan(d * w / (k * speed)));
  std::vector<double> slips;
  bool slid = false;
  for (int n = 0; n < 48000; ++n) {
    const double inputs[] = {speed * n / 48e3, normal};
    network.step(state, inputs);
    const bool slides = network.friction_velocity(state, 0) != 0.0;
    if (slides && !slid) slips.push_back(n / 48e3);
    slid = slides;
  }
  REQUIRE(slips.size() > 5);
  const double period = (slips.back() - slips[1]) / static_cast<double>(slips.size() - 2);
  CHECK(period == Approx(expected).epsilon(2e-3));
}

TEST_CASE("friction: the law's coefficients, and the fit of rosin", "[physics]") {
  CHECK(kRosin.coefficient(0.0) == Approx(1.2));
  CHECK(kRosin.coefficient(0.1) == Approx(0.35 + 0.4 * std::exp(-10.0) + 0.45 * std::exp(-1.0)));
  const double h = 1e-7;
  CHECK(kRosin.slope(0.05) ==
        Approx((kRosin.coefficient(0.05 + h) - kRosin.coefficient(0.05 - h)) / (2 * h)));
}

TEST_CASE("friction: where three ways are open, it goes on as before", "[physics]") {
  // mu falls from 1.2 to 0.35; with 1 N and 0.5 m/s/N the line v + 0.5 F = 0.4 cuts the curve twice beside
  // the holding branch.
  const auto solve = [](double free, double before) {
    return solve_friction(
        kRosin, 0.0,
        {.normal = 1.0, .free = free, .mobility = 0.5, .before = before, .holds = before == 0.0});
  };
  const auto held = solve(0.4, 0.0);
  CHECK(held.velocity == 0.0);
  CHECK(held.after == 0.0);
  CHECK(held.force == Approx(0.8));
  const auto slid = solve(0.4, 0.2);
  CHECK(slid.velocity > 0.0);
  CHECK(slid.force == Approx(kRosin.coefficient(slid.velocity)));
  CHECK(slid.velocity + 0.5 * slid.force == Approx(0.4));
  // Too fast to be held.
  CHECK(solve(0.7, 0.0).velocity > 0.0);
  CHECK(solve(-0.7, 0.0).velocity == -solve(0.7, 0.0).velocity);
}

TEST_CASE("friction: what slides stops within a step and stays, or turns where it cannot be held",
          "[physics]") {
  const FrictionLaw law{0.5, {}};
  const auto solve = [&](double free, double before, double heat) {
    return solve_friction(law, 0.0,
                          {.normal = 1.0,
                           .free = free,
                           .mobility = 0.5,
                           .before = before,
                           .centred = true,
                           .memory = {.margin = -1.0, .heat = heat}});
  };
  // 0.2 m/s that 0.3 N drive on or hold back: 1 m/s/N over the step; friction is 0.5 N.
  CHECK(solve(0.2 + 0.15, 0.2, 1.0).after == 0.0);
  CHECK(solve(0.2 - 0.15, 0.2, 1.0).after == 0.0);
  CHECK(solve(0.2 - 0.15, 0.2, 1.0).velocity == Approx(0.1));
  // Held back by more than it can hold with, 0.6 N: stops after 2/11 of the step, then turns.
  CHECK(solve(0.2 - 0.3, 0.2, 1.0).after == Approx(-9.0 / 11 * 0.1));
  // Faster than friction can stop within the step.
  CHECK(solve(0.8, 0.8, 1.0).after == Approx(0.3));
  // A stop that would give energy which the slide has not lost.
  const auto poor = solve(0.2 - 0.15, 0.2, 0.0);
  CHECK(poor.force * poor.velocity >= 0.0);
}

TEST_CASE("friction: breaks away between two steps, where it can hold no longer", "[physics]") {
  // 1 N more in each step; 0.8 N could be held. 0.5 N in the step before, 1.5 N now: on the way from one
  // middle to the next it has slid for 0.7 of a step, and the rest of this one, 0.5.
  const FrictionLaw law{0.2, {{{0.6, 1e-9}, {}}}};
  const FrictionStep step{
      .normal = 1.0, .free = 1.5, .mobility = 1.0, .holds = true, .centred = true, .memory = {.margin = 0.3}};
  // From 0.8 N to 2 N, mean 1.4 N, less 0.2 N, over 1.2 steps: 2 m/s/N a step at the end. The friction falls
  // in no time: the first of 32 short steps is lost.
  const auto found = solve_friction(law, 0.0, step);
  CHECK(found.after + 2.0 * found.memory.owed == Approx(2.0 * 1.2 * (1.4 - 0.2)).epsilon(1.0 / 32));
  CHECK(found.force >= 0.0);
  // What has jumped has no place in between.
  auto jumped = step;
  jumped.memory.margin = FrictionMemory::kUnknown;
  CHECK(solve_friction(law, 0.0, jumped).force == Approx(0.2).epsilon(1e-3));
}

TEST_CASE("friction: takes out what it gives as heat, with contacts and other frictions beside it",
          "[physics]") {
  // Two blocks on each other on a shaken table, between walls, one brake pressed by the spring between them.
  const auto solver = GENERATE(Solver::Passive, Solver::Implicit);
  NetworkElements elements;
  elements.points = {mass(0.1, 0.0, 1.0), mass(0.05), ground(), {Point::Kind::Motion, 0, 0, 0, {0, {}}}};
  elements.springs = {{2, 0, 500.0, 0.01, 0.0}, {0, 1, 300.0, 0.0, 0.0}};
  elements.contacts = {
      {.lower = 1, .upper = 2, .stiffness = 1e6, .loss = 0.2, .restitution = {}, .offset = -0.02}};
  Friction rosin{.lower = 3, .upper = 0, .law = kRosin, .viscous = 0.1, .normal = {1, {}}};
  Friction brake{.lower = 0, .upper = 1, .law = {}, .normal = {}, .normal_spring = 1};
  brake.law.kinetic = 0.2;
  elements.frictions = {rosin, brake};
  const auto network = Network::make(elements, 2, 96_kHz, solver, 1).value();
  auto state = network.initial_state();
  test::EnergyAudit audit(elements, 2, 96_kHz);
  double start = 0.0;
  for (int n = 0; n < 48000; ++n) {
    const double inputs[] = {0.01 * std::sin(0.002 * n), 1.0 + std::sin(0.0007 * n)};
    audit.step(network, state, inputs);
    if (n > 0) continue;
    start = network.energy(state);
    audit.supplied = audit.dissipated = 0.0;
  }
  CHECK(audit.dissipated > 0.05);
  CHECK(network.energy(state) - start ==
        Approx(audit.supplied - audit.dissipated).margin(1e-10 * audit.dissipated).epsilon(0));
}

// Both hold, and neither can hold what the start of the belts would need: m v' = N_1 mu_1 - N_2 mu_2.
TEST_CASE("friction: a mass between two belts that part goes no faster than their friction drives it",
          "[physics]") {
  const auto solver = any_solver();
  constexpr double kMass = 0.064, kRate = 44100.0, kMost[] = {1.5, 0.4};
  NetworkElements elements;
  elements.points = {
      mass(kMass), {Point::Kind::Motion, 0, 0, 0, {0, {}}}, {Point::Kind::Motion, 0, 0, 0, {1, {}}}};
  elements.frictions = {coulomb(1, 0, 0.3, 2), coulomb(2, 0, 0.1, 3)};
  const auto network = Network::make(elements, 4, Hertz{kRate}, solver, 1).value();
  auto state = network.initial_state();
  constexpr double kAcceleration = (kMost[0] - kMost[1]) / kMass;
  for (int n = 0; n < 60; ++n) {  // after 77 frames it is as fast as the first belt
    const double t = n / kRate, inputs[] = {0.03 * t, -0.0076 * t, 5.0, 4.0};
    network.step(state, inputs);
    CAPTURE(static_cast<int>(solver), n);
    for (int f = 0; f < 2; ++f) CHECK(std::abs(network.friction_force(state, f)) <= kMost[f] * (1 + 1e-12));
    CHECK(network.velocity(state, 0) == Approx(kAcceleration * t).margin(2.0 * kAcceleration / kRate));
  }
}

TEST_CASE("friction: the push of a contact is its normal force", "[physics]") {
  // A weight of 5 N rests on a contact; the block beside it is held by up to 0.4 of that.
  NetworkElements elements;
  elements.points = {mass(0.1, 0.0), mass(0.05), ground()};
  elements.contacts = {{.lower = 2, .upper = 0, .stiffness = 1e7, .loss = 1.0, .restitution = {}}};
  elements.springs = {{2, 0, 0.0, 20.0, 0.0}};
  elements.forces = {{0, {0, {}}}, {1, {1, {}}}};
  Friction brake{.lower = 1, .upper = 2, .law = {}, .normal = {}, .normal_contact = 0};
  brake.law.kinetic = 0.4;
  elements.frictions = {brake};
  const auto network = Network::make(elements, 2, 48_kHz, Solver::Passive, 1).value();
  auto state = network.initial_state();
  const auto pull = GENERATE(1.95, 2.05);
  for (int n = 0; n < 96000; ++n) {
    const double inputs[] = {-5.0, n < 48000 ? 0.0 : pull};  // settled first
    network.step(state, inputs);
  }
  // Quadratised energy: after the landing the root is 3e-5 off the law, and the force with it.
  CHECK(network.contact_force(state, 0) == Approx(5.0).epsilon(1e-4));
  if (pull < 2.0)
    CHECK(network.friction_velocity(state, 0) == 0.0);
  else
    CHECK(network.friction_velocity(state, 0) == Approx(0.05 / 0.05).epsilon(4e-3));
}
