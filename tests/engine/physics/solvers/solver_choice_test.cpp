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

TEST_CASE("solver choice: the error of an oscillator is that of its roots", "[physics]") {
  // To second order (w k)^2 / 24, above for explicit and centred steps, and (w k)^2 / 12 below for averaged
  // ones.
  CHECK(oscillator_error(Stepping::Explicit, 0.01, 0.0) == Approx(0.01 / 24).epsilon(0.01));
  CHECK(oscillator_error(Stepping::Centred, 0.01, 0.0) == Approx(0.01 / 24).epsilon(0.01));
  CHECK(oscillator_error(Stepping::Averaged, 0.01, 0.0) == Approx(0.01 / 12).epsilon(0.01));
  // A mass on a damper: 1 - c k, and (1 - c k / 2) / (1 + c k / 2), in place of e^(-c k). Two decays, one r
  // times as fast as the other, are r^(-1 / (r - 1)) - r^(-r / (r - 1)) apart at most.
  const auto apart = [](double r) { return std::pow(r, -1 / (r - 1)) - std::pow(r, -r / (r - 1)); };
  CHECK(oscillator_error(Stepping::Explicit, 0.0, 0.1) == Approx(apart(-std::log(0.9) / 0.1)).epsilon(1e-9));
  CHECK(oscillator_error(Stepping::Centred, 0.0, 0.1) ==
        Approx(apart(2 * std::atanh(0.05) / 0.1)).epsilon(1e-6));
  CHECK(oscillator_error(Stepping::Explicit, 0.0, 0.9) == Approx(std::exp(-0.9) - 0.1).epsilon(1e-9));
  // One that swings loses 1 - c k of its energy a step, in place of e^(-c k).
  CHECK(oscillator_error(Stepping::Explicit, 1e-4, 1e-3) == Approx(0.5e-3).epsilon(0.01));
  // Towards the end of the step it is stopped as it should be; where it rings at half the rate nothing is
  // right.
  CHECK(oscillator_error(Stepping::Centred, 0.0, 1e4) < 1e-3);
  CHECK(oscillator_error(Stepping::Centred, 0.0, 3.9) > 0.3);
  CHECK(oscillator_error(Stepping::Exact, 3.0, 3.0) == 0.0);
}

TEST_CASE("solver choice: dampers, ports and coils count", "[physics]") {
  // A gram on 43.2 N s/m at 48 kHz: c k = 0.9, half a step too fast in the explicit solver.
  NetworkElements damped;
  damped.points = {mass(1e-3), {Point::Kind::Ground, 0, 0, 0, {}}};
  damped.springs = {{1, 0, 0.0, 43.2, 0.0}};
  const auto choice = choose_solver(damped, 48_kHz, 1);
  CHECK(of(choice, Solver::Explicit).error == Approx(std::exp(-0.9) - 0.1).epsilon(1e-6));
  CHECK(choice.solver == Solver::Exact);

  NetworkElements port;
  port.points = {mass(1e-3)};
  port.ports = {{0, 1e5, {}}};
  CHECK(of(choose_solver(port, 48_kHz, 1), Solver::Passive).error == 1.0);
  CHECK(choose_solver(port, 48_kHz, 1).solver == Solver::Exact);

  // R k / L = 0.5 by itself, as it hardly moves.
  NetworkElements coil;
  coil.points = {mass(1.0)};
  coil.coils = {{0, -1, 1e-3, 24.0, 1e-3, {}}};
  CHECK(of(choose_solver(coil, 48_kHz, 1), Solver::Passive).error ==
        Approx(2 * std::atanh(0.25) / 0.5 - 1).epsilon(1e-6));
}

TEST_CASE("solver choice: one step a frame will do where a contact is over within two", "[physics]") {
  // A gram on 6.6e9 N/m^1.5 touches for a frame; it leaves with the restitution, to rounding.
  NetworkElements elements;
  elements.points = {{Point::Kind::Mass, 1e-3, 4.2e-4, -2.0, {}}, {Point::Kind::Ground, 0, 0, 0, {}}};
  elements.contacts = {{.lower = 1, .upper = 0, .stiffness = 6.63e9, .exponent = 1.5, .restitution = 0.01}};
  const auto choice = choose_solver(elements, 48_kHz, 0);
  CHECK(choice.oversample == 1);
  CHECK(of(choice, choice.solver).contact_frames == 2.0);
  const auto network = Network::make(elements, 0, 48_kHz, choice.solver, 1).value();
  auto state = network.initial_state();
  for (int n = 0; n < 30; ++n) network.step(state, nullptr);
  CHECK(network.velocity(state, 0) == Approx(0.02).epsilon(1e-6));
  // It met the ground after 10.08 frames, and two frames of its way are 2 * 2 / 48000 m.
  CHECK(std::abs(network.position(state, 0) - 0.02 * (30 - 10.08) / 48e3) <= 2 * 2.0 / 48e3);
}

TEST_CASE("solver choice: the two sides of a spring are no short contact", "[physics]") {
  NetworkElements elements;
  elements.points = {mass(1e-3), {Point::Kind::Ground, 0, 0, 0, {}}};
  for (const int side : {0, 1})
    elements.contacts.push_back(
        {.lower = side, .upper = 1 - side, .stiffness = 6.63e9, .exponent = 3.0, .restitution = {}});
  for (const auto& candidate : choose_solver(elements, 48_kHz, 1).candidates)
    CHECK(candidate.contact_frames == 0.0);
}

TEST_CASE("solver choice: what was chosen runs, and says what it is", "[physics]") {
  const auto network = Network::make(chain(3, 0.5), 0, 48_kHz, Solver::Auto, 0).value();
  CHECK(network.solver() == Solver::Exact);
  CHECK(network.choice().candidates.size() == 4);
}
