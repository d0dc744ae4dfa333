#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "engine/physics/network.h"

using namespace tactus;

namespace {

NetworkElements on_a_port(double mass, double impedance, double velocity) {
  NetworkElements elements;
  elements.points = {{Point::Kind::Mass, mass, 0, velocity, {}}};
  elements.ports = {{0, impedance, {0, {}}}};
  return elements;
}

}  // namespace

TEST_CASE("port: without an answer it takes a mass's speed away as exp(-Z t / m)", "[physics]") {
  const auto solver = GENERATE(Solver::Passive, Solver::Explicit, Solver::Implicit, Solver::Exact);
  CAPTURE(static_cast<int>(solver));
  const auto network = Network::make(on_a_port(0.01, 0.5, 1.0), 1, 48_kHz, solver, 1).value();
  auto state = network.initial_state();
  const double silence = 0.0;
  for (int n = 0; n < 960; ++n) network.step(state, &silence);  // Z t / m = 1
  CHECK(network.velocity(state, 0) == Approx(std::exp(-1.0)).epsilon(1e-3));
  CHECK(network.wave(state, 0) == Approx(-0.5 * network.velocity(state, 0)).epsilon(2e-3));
}

TEST_CASE("port: a free mass gives a wave back whole, below Z / m inverted", "[physics]") {
  // b = a - Z v with m v' = 2a - Z v:  B / A = (s - Z/m) / (s + Z/m); at rest b = -a.
  const auto network = Network::make(on_a_port(0.01, 50.0, 0.0), 1, 48_kHz, Solver::Exact, 1).value();
  auto state = network.initial_state();
  const double wave = 3.0;
  for (int n = 0; n < 4800; ++n) network.step(state, &wave);
  CHECK(network.wave(state, 0) == Approx(-3.0).epsilon(1e-9));
  CHECK(network.velocity(state, 0) == Approx(2 * 3.0 / 50.0).epsilon(1e-9));
  CHECK(network.port_force(state, 0) == Approx(0.0).margin(1e-9));
}

TEST_CASE("port: what comes out and what is stored never exceeds what went in", "[physics]") {
  const auto solver = GENERATE(Solver::Passive, Solver::Implicit, Solver::Exact);
  const auto oversample = GENERATE(1, 3);
  CAPTURE(static_cast<int>(solver), oversample);
  const double rate = 8e3, impedance = 2.0;
  auto elements = on_a_port(0.001, impedance, 0.0);
  elements.points.push_back({Point::Kind::Ground, 0, 0, 0, {}});
  elements.springs = {{1, 0, 2e4, 0.0, 0.0}};
  elements.contacts = {{.lower = 0, .upper = 1, .stiffness = 1e8, .restitution = {}, .offset = -1e-4}};
  const auto network = Network::make(elements, 1, Hertz{rate}, solver, oversample).value();
  auto state = network.initial_state();
  std::mt19937 random(7);
  std::uniform_real_distribution<double> noise(-1.0, 1.0);
  double in = 0.0, out = 0.0;
  for (int n = 0; n < 100'000; ++n) {
    const double wave = noise(random);
    network.step(state, &wave);
    in += wave * wave / impedance / rate;
    out += std::pow(network.wave(state, 0), 2) / impedance / rate;
    if (n % 100 == 0) REQUIRE(out + network.energy(state) <= in * (1 + 1e-9) + 1e-4);
  }
  CHECK(out > 0.5 * in);
}
