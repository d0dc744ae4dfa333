#include "engine/physics/linearised.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

using namespace tactus;

namespace {

/// A mass on a spring and a damper to the ground, pushed by signal 0.
NetworkElements oscillator(double mass, double stiffness, double damping) {
  NetworkElements elements;
  elements.points.push_back({.kind = Point::Kind::Ground, .input = {}});
  elements.points.push_back({.kind = Point::Kind::Mass, .mass = mass, .input = {}});
  elements.springs.push_back({0, 1, stiffness, damping, 0.0});
  elements.forces.push_back({1, {0, {}}});
  return elements;
}

LinearStep step_of(const NetworkElements& elements, double rate, Solver solver, int oversample = 1) {
  const auto network = Network::make(elements, 1, Hertz{rate}, solver, oversample);
  return linear_step(*network, elements, 1);
}

}  // namespace

// Poles of the mass-interaction solver: |z| = sqrt(1 - Z), cos(angle) = (2 - K - Z) / (2 sqrt(1 - Z)), with K
// = k T^2 / m and Z = z T / m.
TEST_CASE("linearised: an explicit oscillator has the poles of its difference equation", "[physics]") {
  const double mass = 0.02, stiffness = 5000, damping = 0.3, rate = 8000;
  const double k = stiffness / (mass * rate * rate), z = damping / (mass * rate);
  const auto found = modes(step_of(oscillator(mass, stiffness, damping), rate, Solver::Explicit).a);
  CHECK(std::abs(found[0].pole) == Approx(std::sqrt(1 - z)).epsilon(1e-9));
  CHECK(std::abs(std::arg(found[0].pole)) ==
        Approx(std::acos((2 - k - z) / (2 * std::sqrt(1 - z)))).epsilon(1e-9));
}

TEST_CASE("linearised: the least rate is where K + 2 Z = 4", "[physics]") {
  const double mass = 0.01, stiffness = 2e6, damping = GENERATE(0.0, 20.0);
  // k T^2 / m + 2 z T / m = 4, solved for 1/T.
  const double expected = (damping + std::sqrt(damping * damping + 4 * stiffness * mass)) / (4 * mass);
  const auto rate = least_rate(oscillator(mass, stiffness, damping), 1, Solver::Explicit);
  REQUIRE(rate);
  CHECK(rate->value == Approx(expected).epsilon(0.002));
  CHECK_FALSE(least_rate(oscillator(mass, stiffness, damping), 1, Solver::Passive));
}

TEST_CASE("linearised: the response is that of stepping the network", "[physics]") {
  const auto solver = GENERATE(Solver::Explicit, Solver::Passive);
  const int oversample = GENERATE(1, 3);
  const double rate = 4000;
  auto elements = oscillator(0.02, 5000, 2);
  elements.coils.push_back({1, -1, 3, 6, 1e-3, {1, {}}});
  const auto network = Network::make(elements, 2, Hertz{rate}, solver, oversample);
  const auto step = linear_step(*network, elements, 2);
  Eigen::MatrixXd c = Eigen::MatrixXd::Zero(1, step.a.rows());
  c(0, 0) = 1;  // the position of the mass
  const StepResponse response(step, c, modes(step.a));
  for (const int input : {0, 1}) {
    auto state = network->initial_state();
    double in[2] = {0, 0};
    network->step(state, in);
    const auto z = std::polar(1.0, 2 * std::numbers::pi * 90 / rate);
    std::complex<double> transform = 0, turn = 1;
    in[input] = 1;
    for (int n = 0; n < 8000; ++n) {
      transform += turn * network->position(state, 1);
      turn /= z;
      network->step(state, in);
      in[input] = 0;
    }
    CHECK(std::abs(transform - response.at(z)(0, input)) < 1e-9 * std::abs(transform));
    REQUIRE(response.by_modes());
    CHECK(std::abs(transform - response.at(z, 0, input)) < 1e-9 * std::abs(transform));
  }
}

TEST_CASE("linearised: responses by modes are those by elimination, where modes can be told apart",
          "[physics]") {
  // A string of 60 masses of which one is driven, held loosely, at frequencies on and beside the unit circle.
  NetworkElements elements;
  elements.points.push_back({.kind = Point::Kind::Ground, .input = {}});
  for (int i = 1; i <= 60; ++i) {
    elements.points.push_back({.kind = Point::Kind::Mass, .mass = 1e-4, .input = {}});
    elements.springs.push_back({i - 1, i, 6e4, 1e-4, 0.0});
    elements.springs.push_back({0, i, 0.0, 1e-5, 0.0});
  }
  elements.forces.push_back({30, {0, {}}});
  const auto network = Network::make(elements, 1, 48_kHz, Solver::Passive, 1);
  const auto step = linear_step(*network, elements, 1);
  const Eigen::MatrixXd c = Eigen::MatrixXd::Identity(60, step.a.rows());
  const StepResponse response(step, c, modes(step.a));
  REQUIRE(response.by_modes());
  for (const double size : {1.0, 1.001, 1.5})
    for (double turn = 0.001; turn < 3.1; turn *= 1.3) {
      const auto z = std::polar(size, turn);
      const auto all = response.at(z);
      const double largest = all.cwiseAbs().maxCoeff();
      for (int row = 0; row < 60; ++row) {
        CAPTURE(size, turn, row);
        REQUIRE(std::abs(response.at(z, row, 0) - all(row, 0)) <= 1e-10 * largest);
      }
    }
  // A mass that nothing holds: both of its modes rest.
  NetworkElements free;
  free.points.push_back({.kind = Point::Kind::Mass, .mass = 1.0, .input = {}});
  free.forces.push_back({0, {0, {}}});
  const auto loose = Network::make(free, 1, 48_kHz, Solver::Passive, 1);
  const auto free_step = linear_step(*loose, free, 1);
  CHECK_FALSE(StepResponse(free_step, Eigen::MatrixXd::Identity(1, free_step.a.rows()), modes(free_step.a))
                  .by_modes());
  // Without an input or an output there is nothing to answer.
  auto undriven = step;
  undriven.b.resize(undriven.b.rows(), 0);
  CHECK_FALSE(StepResponse(undriven, c, modes(step.a)).by_modes());
  CHECK_FALSE(StepResponse(step, c.topRows(0), modes(step.a)).by_modes());
}

TEST_CASE("linearised: a closed contact is the spring that it is at its indentation", "[physics]") {
  NetworkElements elements;
  elements.points.push_back({.kind = Point::Kind::Ground, .input = {}});
  elements.points.push_back({.kind = Point::Kind::Mass, .mass = 0.0125, .position = 0.01, .input = {}});
  elements.contacts.push_back({0, 1, 5e6, 1.5, 0.0, {}, 0.0});
  const double push = 10, depth = std::pow(push / 5e6, 1 / 1.5), tangent_stiffness = 1.5 * push / depth;
  const auto open = tangent(elements, {}), closed = tangent(elements, {{0}, push});
  CHECK(spectral_radius(step_of(open, 192000, Solver::Explicit).a) == Approx(1).margin(kRoundOfRadius));
  const auto found = modes(step_of(closed, 192000, Solver::Explicit).a);
  const double hertz = std::abs(std::arg(found[0].pole)) * 192000 / (2 * std::numbers::pi);
  // The solver rings sharp by (wT)^2 / 24, 2e-4 here.
  CHECK(hertz == Approx(std::sqrt(tangent_stiffness / 0.0125) / (2 * std::numbers::pi)).epsilon(1e-3));
}

TEST_CASE("linearised: a long chain is found to grow where its stiffest mode passes 4", "[physics]") {
  // Between fixed ends the stiffest mode has 4 K sin^2 close to 4 K: it grows above K = k T^2 / m = 1.
  NetworkElements elements;
  const int masses = 200;
  for (int i = 0; i < masses; ++i)
    elements.points.push_back({.kind = Point::Kind::Mass, .mass = 0.001, .input = {}});
  elements.points.push_back({.kind = Point::Kind::Ground, .input = {}});
  const double stiffness = 1e4;
  for (int i = 0; i <= masses; ++i)
    elements.springs.push_back({i == 0 ? masses : i - 1, i, stiffness, 0.0, 0.0});
  const double border = std::sqrt(stiffness / 0.001);
  for (const double rate : {1.01 * border, 0.99 * border}) {
    const auto network = Network::make(elements, 0, Hertz{rate}, Solver::Explicit, 1);
    const double k = stiffness / 0.001 / (rate * rate);
    const double expected = k < 1 ? 1 : std::pow(std::sqrt(k) + std::sqrt(k - 1), 2);
    CHECK(radius_by_running(*network, elements, 0) == Approx(expected).epsilon(0.01));
  }
}
