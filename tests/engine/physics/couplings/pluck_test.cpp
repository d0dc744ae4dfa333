#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "engine/physics/network.h"
#include "tests/engine/physics/energy_audit.h"

using namespace tactus;

namespace {

Point mass(double kilogram) { return {Point::Kind::Mass, kilogram, 0, 0, {}}; }
Point ground() { return {Point::Kind::Ground, 0, 0, 0, {}}; }
Point driven() { return {Point::Kind::Motion, 0, 0, 0, {0, {}}}; }

}  // namespace

TEST_CASE("pluck: draws slowly, lets go at its limit, and the string swings at its own frequency",
          "[physics]") {
  // Drawn by F = 2 N the string stands F / k out; let go it swings as far either way.
  const auto solver = GENERATE(Solver::Passive, Solver::Explicit, Solver::Implicit, Solver::Exact);
  CAPTURE(static_cast<int>(solver));
  const double k = 1000.0, m = 0.01;
  NetworkElements elements;
  elements.points = {mass(m), ground(), driven()};
  elements.springs = {{1, 0, k, 0.0, 0.0}};
  elements.bonds = {
      {.lower = 2, .upper = 0, .law = std::make_shared<LinearBond>(500.0), .damping = 0.0, .limit = 2.0}};
  const auto network = Network::make(elements, 1, 48_kHz, solver, 1).value();
  auto state = network.initial_state();
  double highest = 0.0, lowest = 0.0, hardest = 0.0;
  int let_go = 0;
  std::vector<double> crossings;
  double before = 0.0;
  for (int n = 0; n < 96000; ++n) {
    // 2 mm of string and 4 mm of plectrum at 2 N: passed after 0.6 s, then it stays out of reach.
    const double place = std::min(0.02, 0.01 * n / 48e3);
    network.step(state, &place);
    const double x = network.position(state, 0);
    hardest = std::max(hardest, network.bond_force(state, 0));
    if (let_go == 0 && state.slipped[0] != 0.0) let_go = n;
    if (let_go > 0) highest = std::max(highest, x), lowest = std::min(lowest, x);
    if (let_go > 0 && before < 0.0 && x >= 0.0) crossings.push_back(n - x / (x - before));
    before = x;
  }
  CHECK(let_go / 48e3 == Approx(0.6).epsilon(0.01));
  CHECK(hardest == Approx(2.0).epsilon(0.005));
  CHECK(highest == Approx(2.0 / k).epsilon(0.02));
  CHECK(lowest == Approx(-2.0 / k).epsilon(0.02));
  REQUIRE(crossings.size() > 20);
  const double period =
      (crossings.back() - crossings.front()) / static_cast<double>(crossings.size() - 1) / 48e3;
  CHECK(1 / period == Approx(std::sqrt(k / m) / (2 * std::numbers::pi)).epsilon(2e-4));
}

TEST_CASE("pluck: takes the string up again when they pass each other", "[physics]") {
  NetworkElements elements;
  elements.points = {mass(0.001), ground(), driven()};
  elements.springs = {{1, 0, 1000.0, 0.3, 0.0}};
  elements.bonds = {
      {.lower = 2, .upper = 0, .law = std::make_shared<LinearBond>(5000.0), .damping = 0.0, .limit = 2.0}};
  const auto network = Network::make(elements, 1, 48_kHz, Solver::Passive, 1).value();
  auto state = network.initial_state();
  int plucked = 0;
  double slipped = 0.0;
  for (int n = 0; n < 4 * 48000; ++n) {
    // To and fro once a second over 10 mm: let go on each way.
    const double place = 0.01 * std::sin(2 * std::numbers::pi * n / 48e3);
    network.step(state, &place);
    plucked += slipped == 0.0 && state.slipped[0] != 0.0;
    slipped = state.slipped[0];
  }
  CHECK(plucked == 8);
}

TEST_CASE("pluck: what it lets go is lost, and no more", "[physics]") {
  const auto solver = GENERATE(Solver::Passive, Solver::Implicit);
  NetworkElements elements;
  elements.points = {mass(0.01), ground(), driven()};
  elements.springs = {{1, 0, 1000.0, 0.1, 0.0}};
  elements.bonds = {
      {.lower = 2, .upper = 0, .law = std::make_shared<LinearBond>(500.0), .damping = 0.2, .limit = 2.0}};
  const auto network = Network::make(elements, 1, 48_kHz, solver, 1).value();
  auto state = network.initial_state();
  test::EnergyAudit audit(elements, 1, 48_kHz);
  for (int n = 0; n < 96000; ++n) {
    const double place = 0.01 * std::sin(2 * std::numbers::pi * n / 48e3);
    audit.step(network, state, &place);
  }
  CHECK(audit.dissipated > 0.008);  // four times 2 N / 2 * 4 mm
  CHECK(network.energy(state) == Approx(audit.supplied - audit.dissipated).margin(1e-10 * audit.dissipated));
}
