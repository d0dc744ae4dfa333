#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "engine/physics/network.h"
#include "tests/engine/physics/energy_audit.h"

using namespace tactus;

namespace {

Point mass(double kilogram, double position, double velocity) {
  return {Point::Kind::Mass, kilogram, position, velocity, {}};
}
Point ground(double position) { return {Point::Kind::Ground, 0, position, 0, {}}; }

Contact contact(int lower, int upper, double loss = 0.0) {
  return {.lower = lower, .upper = upper, .stiffness = 5e6, .exponent = 1.5, .loss = loss, .restitution = {}};
}

}  // namespace

TEST_CASE("energy: a body between two walls keeps its energy over a million steps", "[physics]") {
  NetworkElements elements;
  elements.points = {mass(0.0125, 0.0, 1.0), ground(0.002), ground(-0.002)};
  elements.contacts = {contact(0, 1), contact(2, 0)};
  const auto solver = GENERATE(Solver::Passive, Solver::Implicit, Solver::Exact);
  const auto network = Network::make(elements, 0, 48_kHz, solver, 1).value();
  auto state = network.initial_state();
  const double start = network.energy(state);
  CHECK(start == Approx(0.5 * 0.0125));
  double worst = 0;
  for (int i = 0; i < 1'000'000; ++i) {
    network.step(state, nullptr);
    worst = std::max(worst, std::abs(network.energy(state) / start - 1.0));
  }
  CHECK(worst < 1e-10);
}

TEST_CASE("energy: averaged springs count an oscillation above the rate by 1 / (1 + (w k / 2)^2)",
          "[physics]") {
  // Trapezoidal: tan(turn / 2) = w k / 2 a step, and half a step before a frame the mean extension is
  // X cos(turn / 2) and the change X 2 sin(turn / 2), so that K X^2 / 2 cos^2(turn / 2) is kept.
  const double stiffness = GENERATE(1e4, 1e6, 2e10), extension = 4e-4;
  const auto solver = GENERATE(Solver::Passive, Solver::Implicit);
  NetworkElements elements;
  elements.points = {mass(50e-6, 0.0, 0.0), mass(10e-6, extension, 0.0)};
  elements.springs = {{0, 1, stiffness, 0.0, 0.0}};
  const auto network = Network::make(elements, 0, 48_kHz, solver, 1).value();
  REQUIRE(network.springs_averaged() == (solver == Solver::Implicit || stiffness > 1e5));
  const double k = 1.0 / 48e3, wk = std::sqrt(stiffness * (1 / 50e-6 + 1 / 10e-6)) * k;
  const double stored = 0.5 * stiffness * extension * extension;
  // Centred, tan is sin, and what is kept is K X^2 / 2 (1 - (w k / 2)^2).
  const double right =
      network.springs_averaged() ? stored / (1 + 0.25 * wk * wk) : stored * (1 - 0.25 * wk * wk);
  auto state = network.initial_state();
  for (int n = 0; n < 1000; ++n) {
    REQUIRE(network.energy(state) == Approx(right).epsilon(1e-9));
    network.step(state, nullptr);
  }
}

TEST_CASE("energy: what is stored is what was put in less what was lost", "[physics]") {
  // Every kind of element at once: rounding only, over 200,000 steps.
  const double stiffness = GENERATE(1000.0, 1e10);  // the second one averages the springs
  NetworkElements elements;
  elements.points = {mass(0.0125, 0.02, 0.0),
                     mass(0.035, 0.0, 0.0),
                     ground(0.0),
                     mass(0.02, -0.03, 0.3),
                     {Point::Kind::Motion, 0, 0, 0, {2, {}}},
                     {Point::Kind::Motion, 0, 0, 0, {2, 8_Hz}}};  // a hand
  elements.springs = {{1, 2, stiffness, 1.2, 0.0},
                      {3, 1, 2000.0, 0.1, 0.03},
                      {3, 4, 300.0, 0.5, 0.0},
                      {0, 5, 10.0, 0.02, 0.0}};
  elements.contacts = {contact(1, 0, 0.15), contact(4, 3, 0.3)};
  elements.contacts[1].restitution = 0.5;
  elements.coils = {{1, 3, 6.0, 6.5, 0.8e-3, {0, {}}}};
  elements.forces = {{0, {1, {}}}, {0, {1, 8_Hz}}};
  const auto solver = GENERATE(Solver::Passive, Solver::Implicit);
  const auto network = Network::make(elements, 3, 96_kHz, solver, 1).value();
  CHECK(network.springs_averaged() == (stiffness > 1e6 || solver == Solver::Implicit));
  auto state = network.initial_state();
  test::EnergyAudit audit(elements, 3, 96_kHz);
  double start = 0;
  for (int n = 0; n < 100'000; ++n) {
    const double inputs[] = {n % 1500 < 100 ? 10.0 : 0.0, -0.3, 0.02 * std::sin(0.001 * n)};
    audit.step(network, state, inputs);
    if (n > 0) continue;
    start = network.energy(state);  // from here: the first step puts points to their places
    audit.supplied = audit.dissipated = 0.0;
  }
  CHECK(audit.dissipated > 0.1);
  CHECK(network.energy(state) - start ==
        Approx(audit.supplied - audit.dissipated).margin(1e-10 * audit.dissipated));
}

TEST_CASE("energy: what is far too stiff for the rate starts with the energy that it has", "[physics]") {
  // A milligram on 1e9 N/m, 1 um out: w T = 660. And a gram that runs into 1e5 N s/m, and deep in a contact.
  const auto solver = GENERATE(Solver::Passive, Solver::Implicit, Solver::Exact);
  CAPTURE(static_cast<int>(solver));
  const auto largest = [&](const NetworkElements& elements) {
    const auto network = Network::make(elements, 0, 48_kHz, solver, 1).value();
    auto state = network.initial_state();
    double most = network.energy(state);
    for (int n = 0; n < 4800; ++n) {
      network.step(state, nullptr);
      most = std::max(most, network.energy(state));
    }
    return most;
  };
  NetworkElements spring;
  spring.points = {mass(1e-6, 1e-6, 0.0), ground(0.0)};
  spring.springs = {{1, 0, 1e9, 0.0, 0.0}};
  CHECK(largest(spring) < 5e-4 * 1.01);
  NetworkElements damper;
  damper.points = {mass(1e-3, 0.0, 1.0), ground(0.0)};
  damper.springs = {{1, 0, 0.0, 1e5, 0.0}};
  CHECK(largest(damper) < 5e-4 * 1.01);
  NetworkElements deep;
  deep.points = {mass(1e-3, 1e-3, 0.0), ground(0.0)};
  deep.contacts = {contact(0, 1)};
  deep.contacts[0].stiffness = 1e9;
  CHECK(largest(deep) < 1e9 * std::pow(1e-3, 2.5) / 2.5 * 1.01);
}

TEST_CASE("energy: two masses on a link too stiff for the rate swing as they were thrown", "[physics]") {
  // 10 g and 10 g on 1e9 N/m, one at 1 m/s: half of 5 mJ swings, by v/2w each way, v/w between them; w k
  // = 9.3.
  const auto solver = GENERATE(Solver::Passive, Solver::Implicit, Solver::Exact);
  CAPTURE(static_cast<int>(solver));
  NetworkElements pair;
  pair.points = {mass(0.01, 0.0, 1.0), mass(0.01, 0.0, 0.0)};
  pair.springs = {{0, 1, 1e9, 0.0, 0.0}};
  const auto network = Network::make(pair, 0, 48_kHz, solver, 1).value();
  auto state = network.initial_state();
  double most = network.energy(state), apart = 0.0;
  for (int n = 0; n < 4800; ++n) {
    network.step(state, nullptr);
    most = std::max(most, network.energy(state));
    apart = std::max(apart, std::abs(network.position(state, 0) - network.position(state, 1)));
  }
  CHECK(most < 5e-3 * 1.0001);
  CHECK(apart < 1.0001 / std::sqrt(2e11));
  CHECK(apart > 0.97 / std::sqrt(2e11));
  // The centre of mass goes on at half a metre a second.
  CHECK(0.5 * (network.position(state, 0) + network.position(state, 1)) == Approx(0.05).epsilon(1e-3));
}

TEST_CASE("energy: a spring too stiff for the rate swings as far as it was drawn", "[physics]") {
  // A milligram on 1e9 N/m, 1 um out: w k = 659.
  const auto solver = GENERATE(Solver::Passive, Solver::Implicit, Solver::Exact);
  NetworkElements spring;
  spring.points = {mass(1e-6, 1e-6, 0.0), ground(0.0)};
  spring.springs = {{1, 0, 1e9, 0.0, 0.0}};
  const auto network = Network::make(spring, 0, 48_kHz, solver, 1).value();
  auto state = network.initial_state();
  for (int n = 0; n < 4800; ++n) {
    network.step(state, nullptr);
    REQUIRE(std::abs(network.position(state, 0)) < 1.0001e-6);
  }
}

TEST_CASE("energy: a body that starts off an open contact keeps its speed", "[physics]") {
  // Half a frame before it would have been 10 um deep, with up to 10^6 times its energy.
  const double stiffness = GENERATE(1e6, 1e9, 1e13);
  const auto solver = GENERATE(Solver::Passive, Solver::Implicit, Solver::Exact);
  CAPTURE(static_cast<int>(solver), stiffness);
  NetworkElements elements;
  elements.points = {mass(1e-3, -1e-9, -1.0), ground(0.0)};
  elements.contacts = {contact(0, 1, 0.5)};
  elements.contacts[0].stiffness = stiffness;
  const auto network = Network::make(elements, 0, 48_kHz, solver, 1).value();
  auto state = network.initial_state();
  CHECK(network.energy(state) == Approx(5e-4).epsilon(1e-12));
  for (int n = 0; n < 48; ++n) network.step(state, nullptr);
  CHECK(network.velocity(state, 0) == Approx(-1.0).epsilon(1e-12));
  CHECK(network.position(state, 0) == Approx(-1e-3 - 1e-9).epsilon(1e-12));
}

TEST_CASE("energy: bonds that share masses start with what they hold", "[physics]") {
  // Three masses on two bonds each, and thrown; w k up to 2.
  const double stiffness = GENERATE(1e5, 2e6, 1e7);
  const auto solver = GENERATE(Solver::Passive, Solver::Implicit, Solver::Exact);
  CAPTURE(static_cast<int>(solver), stiffness);
  NetworkElements elements;
  elements.points = {mass(0.01, 0.0, 1.0), mass(0.02, 1e-4, -0.5), mass(0.01, -1e-4, 0.5), ground(0.0)};
  const auto law = std::make_shared<LinearBond>(stiffness);
  for (const auto& [lower, upper] : {std::pair{0, 1}, {0, 2}, {1, 2}, {0, 3}})
    elements.bonds.push_back({lower, upper, law, 0.0});
  const double start = 0.5 * (0.01 + 0.02 * 0.25 + 0.01 * 0.25) + 0.5 * stiffness * (1e-8 + 1e-8 + 4e-8);
  const auto network = Network::make(elements, 0, 48_kHz, solver, 1).value();
  auto state = network.initial_state();
  for (int n = 0; n < 100; ++n) {
    network.step(state, nullptr);
    REQUIRE(network.energy(state) <= start * (1.0 + 1e-12));
  }
}

TEST_CASE("energy: nothing but losses never gains", "[physics]") {
  NetworkElements elements;
  elements.points = {mass(0.0125, 0.01, -2.0), mass(0.035, 0.0, 0.0), mass(0.1, -0.01, 1.0), ground(-0.02),
                     ground(0.03)};
  elements.springs = {{1, 3, 1000.0, 0.1, 0.02}};
  elements.contacts = {contact(1, 0, 0.1), contact(2, 1, 3.0), contact(3, 2, 0.1), contact(0, 4, 30.0)};
  // At 4 kHz a contact lasts for 4 steps.
  const auto solver = GENERATE(Solver::Passive, Solver::Implicit, Solver::Exact);
  const auto network = Network::make(elements, 0, 4_kHz, solver, 1).value();
  auto state = network.initial_state();
  double before = network.energy(state);
  const double start = before;
  for (int n = 0; n < 20'000; ++n) {
    network.step(state, nullptr);
    const double now = network.energy(state);
    REQUIRE(now <= before + 1e-14 * start);
    before = now;
  }
  CHECK(before < 0.5 * start);
}

TEST_CASE("energy: a light mass between a pressed body and the ground is not passed through", "[physics]") {
  // 26 g at 0.4 m/s, pressed by 4.2 N, on 0.36 g with a restitution, on the ground: touches of less than a
  // step that another contact drives together again before they part.
  const auto solver = GENERATE(Solver::Passive, Solver::Implicit, Solver::Exact);
  const double push = GENERATE(0.0, -4.2);
  CAPTURE(static_cast<int>(solver), push);
  NetworkElements elements;
  elements.points = {ground(0.0), mass(0.36e-3, 1e-4, 0.0), mass(0.026, 1e-3, -0.4)};
  elements.contacts = {
      {.lower = 0, .upper = 1, .stiffness = 5.7e8, .exponent = 2.0, .loss = 0.0, .restitution = {}},
      {.lower = 1, .upper = 2, .stiffness = 3.4e8, .exponent = 1.5, .loss = 0.0, .restitution = 0.226}};
  elements.forces = {{2, {0, {}}}};
  const auto network = Network::make(elements, 1, 22050_Hz, solver, 1).value();
  auto state = network.initial_state();
  const double start = network.energy(state), from = network.position(state, 2);
  double before = from, lowest = from;
  for (int n = 0; n < 4410; ++n) {
    network.step(state, &push);
    const double now = network.position(state, 2);
    // Centred solvers have their energy half a step before the frame.
    const double work = push * ((solver == Solver::Exact ? now : 0.5 * (now + before)) - from);
    REQUIRE(network.energy(state) <= (start + work) * (1.0 + 1e-9));
    before = now;
    lowest = std::min(lowest, now);
  }
  // All of its 5.9 mJ in the softer contact would be 0.31 mm, in the other 0.22 mm.
  CHECK(lowest > -0.6e-3);
}
