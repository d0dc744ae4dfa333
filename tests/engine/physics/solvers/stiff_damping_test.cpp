#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>
#include <vector>

#include "engine/core/units.h"
#include "engine/physics/network.h"

using namespace tactus;

namespace {

Point mass(double kilogram, double position = 0.0, double velocity = 0.0) {
  return {Point::Kind::Mass, kilogram, position, velocity, {}};
}
Point ground() { return {Point::Kind::Ground, 0, 0, 0, {}}; }

Solver damped_solver() { return GENERATE(Solver::Passive, Solver::Implicit); }

/// A gram of 1 m/s, stopped within far less than a frame: after m v / z.
void check_stop(const NetworkElements& elements, Solver solver, double damping) {
  const auto network = Network::make(elements, 1, 48_kHz, solver, 1).value();
  auto state = network.initial_state();
  const double nothing = 0.0;
  double before = 1.0;
  for (int n = 1; n < 200; ++n) {
    network.step(state, &nothing);
    const double speed = std::abs(network.velocity(state, 0));
    CAPTURE(n, speed);
    // The velocity of the first frame looks back over the stop; a spring beside the damper goes on pulling.
    if (n > 1) CHECK(speed <= 0.1 * before + 1e-12);
    before = speed;
  }
  // A bond's damper has its full force in the step before the start.
  if (elements.bonds.empty()) CHECK(network.position(state, 0) == Approx(1e-3 / damping).epsilon(1e-2));
}

}  // namespace

TEST_CASE("stiff damping: a damper stops a mass within a frame and does not ring", "[physics]") {
  const auto solver = damped_solver();
  const double damping = GENERATE(1e4, 1e8, 1e12);
  CAPTURE(static_cast<int>(solver), damping);
  NetworkElements elements;
  elements.points = {mass(1e-3, 0.0, 1.0), ground()};
  elements.springs = {{1, 0, 0.0, damping, 0.0}};
  check_stop(elements, solver, damping);
}

TEST_CASE("stiff damping: a port stops a mass within a frame and does not ring", "[physics]") {
  const auto solver = damped_solver();
  CAPTURE(static_cast<int>(solver));
  NetworkElements elements;
  elements.points = {mass(1e-3, 0.0, 1.0)};
  elements.ports = {{.on = 0, .impedance = 1e5, .wave = {}}};
  check_stop(elements, solver, 1e5);
}

TEST_CASE("stiff damping: a bond's damper stops a mass within a frame and does not ring", "[physics]") {
  const auto solver = damped_solver();
  CAPTURE(static_cast<int>(solver));
  NetworkElements elements;
  elements.points = {mass(1e-3, 0.0, 1.0), ground()};
  elements.bonds = {{.lower = 0, .upper = 1, .law = std::make_shared<LinearBond>(1e-6), .damping = 1e4}};
  check_stop(elements, solver, 1e4);
}

TEST_CASE("stiff damping: a network at rest never has more energy than its springs were drawn with",
          "[physics]") {
  std::mt19937 random(11);
  const auto decade = [&](double low, double high) {
    return std::pow(10.0, std::uniform_real_distribution(low, high)(random));
  };
  const auto solver = damped_solver();
  for (int draw = 0; draw < 40; ++draw) {
    NetworkElements elements;
    for (int i = 0; i < 8; ++i) elements.points.push_back(mass(decade(-5, 0), 1e-3 * i * (i % 3 - 1)));
    elements.points.push_back(ground());
    for (int i = 0; i < 8; ++i)
      elements.springs.push_back({i, i + 1, decade(1, 6), i % 2 == 0 ? decade(-3, 12) : 0.0, 0.0});
    elements.ports = {{.on = 3, .impedance = decade(-2, 6), .wave = {}}};
    const auto network = Network::make(elements, 0, 48_kHz, solver, 1).value();
    auto state = network.initial_state();
    const double start = network.energy(state);
    for (int n = 0; n < 2000; ++n) {
      network.step(state, nullptr);
      if (!(network.energy(state) <= start * (1 + 1e-9))) FAIL("draw " << draw << ", step " << n);
    }
  }
}

TEST_CASE("stiff damping: a port never sends out more than came in", "[physics]") {
  std::mt19937 random(3);
  std::normal_distribution<double> noise;
  const auto solver = damped_solver();
  const double impedance = GENERATE(1.0, 300.0, 1e5);
  NetworkElements elements;
  elements.points = {mass(1e-3), mass(1e-4), ground()};
  elements.springs = {{2, 0, 1e5, 0.0, 0.0}, {0, 1, 1e6, 0.0, 0.0}};
  elements.ports = {{.on = 0, .impedance = impedance, .wave = {0, {}}}};
  const auto network = Network::make(elements, 1, 48_kHz, solver, 1).value();
  auto state = network.initial_state();
  double in = 0.0, out = 0.0;
  for (int n = 0; n < 4000; ++n) {
    const double wave = n < 2000 ? noise(random) : 0.0;
    network.step(state, &wave);
    in += square(wave), out += square(network.wave(state, 0));
    if (!(out <= in * (1 + 1e-9))) FAIL("frame " << n);
  }
}

TEST_CASE("stiff damping: a mass beside what is damped stiffly swings as beside a wall", "[physics]") {
  // The neighbour creeps by k x / z a second: 3e-7 of the swing in the time of the test.
  const auto solver = damped_solver();
  NetworkElements walled, damped;
  walled.points = {mass(1e-3, 1e-3), ground()};
  walled.springs = {{1, 0, 1e3, 0.0, 0.0}};
  damped.points = {mass(1e-3, 1e-3), ground(), mass(1e-4)};
  damped.springs = {{2, 0, 1e3, 0.0, 0.0}, {1, 2, 0.0, 1e9, 0.0}};
  const auto one = Network::make(walled, 0, 48_kHz, solver, 1).value(),
             other = Network::make(damped, 0, 48_kHz, solver, 1).value();
  auto a = one.initial_state(), b = other.initial_state();
  for (int n = 0; n < 4800; ++n) one.step(a, nullptr), other.step(b, nullptr);
  CHECK(other.position(b, 0) == Approx(one.position(a, 0)).margin(1e-9).epsilon(0));
}
