#include "engine/physics/solvers/solver_choice.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "engine/physics/network.h"

using namespace tactus;

namespace {

Point mass(double kilogram) { return {Point::Kind::Mass, kilogram, 0, 0, {}}; }

/// Masses of 1 kg in a row between walls, K = k fs^2 at 48 kHz.
NetworkElements chain(int masses, double k) {
  NetworkElements elements;
  for (int i = 0; i < masses; ++i) elements.points.push_back(mass(1.0));
  elements.points.push_back({Point::Kind::Ground, 0, 0, 0, {}});
  for (int i = 0; i <= masses; ++i)
    elements.springs.push_back(
        {i == 0 ? masses : i - 1, i == masses ? masses : i, k * 48e3 * 48e3, 0.0, 0.0});
  return elements;
}

const SolverBounds& of(const SolverChoice& choice, Solver solver, int oversample = 1) {
  return *std::find_if(choice.candidates.begin(), choice.candidates.end(),
                       [&](const auto& b) { return b.solver == solver && b.oversample == oversample; });
}

}  // namespace

TEST_CASE("solver choice: soft chains are explicit, the cheapest that will do", "[physics]") {
  // (w k)^2 <= 4 k: at 0.01 the error of a frequency is below 0.04 / 24.
  const auto choice = choose_solver(chain(100, 0.01), 48_kHz, 1);
  CHECK(choice.solver == Solver::Explicit);
  CHECK(of(choice, Solver::Explicit).error == Approx(0.04 / 24).epsilon(0.01));
  CHECK(of(choice, Solver::Explicit).multiplications < of(choice, Solver::Passive).multiplications);
}

TEST_CASE("solver choice: the explicit solver is refused exactly where it is unstable", "[physics]") {
  // One mass between two springs: stable while 2 k < 4.
  CHECK(of(choose_solver(chain(1, 1.99), 48_kHz, 1), Solver::Explicit).stable);
  CHECK_FALSE(of(choose_solver(chain(1, 2.01), 48_kHz, 1), Solver::Explicit).stable);
}

TEST_CASE("solver choice: few stiff masses are stepped exactly", "[physics]") {
  const auto choice = choose_solver(chain(3, 0.5), 48_kHz, 0);
  CHECK(choice.solver == Solver::Exact);
  CHECK(choice.oversample == 1);
  CHECK(of(choice, Solver::Exact).error == 0.0);
}

TEST_CASE("solver choice: many stiff masses take more steps a frame", "[physics]") {
  // At k = 0.5 a step's error is 2 / 24; four steps a frame leave a sixteenth of it, 0.5 %.
  const auto choice = choose_solver(chain(300, 0.5), 48_kHz, 0);
  CHECK(choice.solver == Solver::Explicit);
  CHECK(choice.oversample == 4);
  CHECK(of(choice, Solver::Exact).limit == SolverBounds::Limit::CannotBeMade);
}

TEST_CASE("solver choice: a short contact needs a solver that keeps its energy", "[physics]") {
  // 12.5 g on 5e6 N/m^1.5 at 1 m/s: 1.166 ms, 9.3 steps at 8 kHz, 4.7 at 4 kHz.
  NetworkElements elements;
  elements.points = {mass(0.0125), {Point::Kind::Ground, 0, 0, 0, {}}};
  elements.contacts = {{.lower = 0, .upper = 1, .stiffness = 5e6, .exponent = 1.5, .restitution = {}}};
  const auto slow = choose_solver(elements, 4_kHz, 1);
  CHECK(of(slow, Solver::Explicit).contact_steps == Approx(4.665).epsilon(1e-3));
  CHECK(of(slow, Solver::Explicit).limit == SolverBounds::Limit::ShortContact);
  CHECK(slow.solver != Solver::Explicit);
  CHECK(choose_solver(elements, 48_kHz, 1).solver == Solver::Explicit);
}

TEST_CASE("solver choice: what was chosen runs, and says what it is", "[physics]") {
  const auto network = Network::make(chain(3, 0.5), 0, 48_kHz, Solver::Auto, 0).value();
  CHECK(network.solver() == Solver::Exact);
  CHECK(network.choice().candidates.size() == 4);
}
