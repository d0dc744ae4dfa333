#include "engine/physics/solvers/reference_solver.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "engine/physics/network.h"

using namespace tactus;

namespace {

Point mass(double kg, double at, double velocity) { return {Point::Kind::Mass, kg, at, velocity, {}}; }

/// Cone on its suspension with its coil (voltage: signal 0), a stick that falls on it, a driven table.
NetworkElements drum() {
  NetworkElements elements;
  elements.points = {{Point::Kind::Ground, 0, 0, 0, {}},
                     mass(0.035, 0.0, 0.0),
                     {Point::Kind::Motion, 0, 0, 0, {1, {}}},
                     mass(0.0125, 2e-3, -0.5)};
  elements.springs = {{0, 1, 1000.0, 1.2, 0.0}, {2, 3, 20.0, 0.02, 0.0}};
  elements.contacts = {{.lower = 1, .upper = 3, .stiffness = 5e6, .loss = 0.15, .restitution = {}}};
  elements.coils = {{1, -1, 6.0, 6.5, 0.8e-3, {0, {}}}};
  return elements;
}

Network of(Solver solver, int oversample) {
  return Network::make(drum(), 2, 48_kHz, solver, oversample).value();
}

}  // namespace

TEST_CASE("reference: does not depend on the number of steps a frame", "[physics]") {
  const auto whole = of(Solver::Reference, 1), parts = of(Solver::Reference, 4);
  auto one = whole.initial_state(), other = parts.initial_state();
  for (int n = 0; n < 2400; ++n) {
    const double inputs[] = {n < 960 ? 5.0 : 0.0, 1e-3 * std::sin(0.01 * n)};
    whole.step(one, inputs);
    parts.step(other, inputs);
  }
  for (const int point : {1, 3}) {
    CHECK(whole.position(one, point) == Approx(parts.position(other, point)).epsilon(0).margin(1e-11));
    CHECK(whole.velocity(one, point) == Approx(parts.velocity(other, point)).epsilon(0).margin(1e-8));
  }
  CHECK(whole.current(one, 0) == Approx(parts.current(other, 0)).epsilon(0).margin(1e-8));
}

TEST_CASE("reference: passive and explicit steps come to it as they get smaller", "[physics]") {
  const auto solver = GENERATE(Solver::Passive, Solver::Explicit, Solver::Implicit);
  const auto far = [&](int oversample) {
    const auto reference = of(Solver::Reference, 1), stepped = of(solver, oversample);
    auto wanted = reference.initial_state(), found = stepped.initial_state();
    double most = 0;
    for (int n = 0; n < 960; ++n) {
      const double inputs[] = {5.0, 0.0};
      reference.step(wanted, inputs);
      stepped.step(found, inputs);
      for (const int point : {1, 3})
        most = std::max(most, std::abs(reference.position(wanted, point) - stepped.position(found, point)));
    }
    return most;
  };
  // First order at least: a sixteenth of the step, a twelfth of the error.
  const double coarse = far(1), fine = far(16);
  CAPTURE(coarse, fine);
  CHECK(fine < coarse / 12);
  CHECK(fine < 2e-6);
}

TEST_CASE("reference: a reset repeats it", "[physics]") {
  const auto network = of(Solver::Reference, 1);
  auto state = network.initial_state();
  const double inputs[] = {5.0, 0.0};
  for (int n = 0; n < 300; ++n) network.step(state, inputs);
  const double first = network.position(state, 3);
  network.reset(state);
  for (int n = 0; n < 300; ++n) network.step(state, inputs);
  CHECK(network.position(state, 3) == first);
}
