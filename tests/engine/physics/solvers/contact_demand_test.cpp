#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "engine/physics/network.h"
#include "engine/physics/solvers/solver_choice.h"

using namespace tactus;

namespace {

constexpr double kMass = 1e-3, kRate = 48000.0;

Point mass(double kilogram, double at = 0.0, double velocity = 0.0) {
  return {Point::Kind::Mass, kilogram, at, velocity, {}};
}

Contact contact(int lower, int upper, double stiffness, double exponent) {
  return {.lower = lower, .upper = upper, .stiffness = stiffness, .exponent = exponent, .restitution = {}};
}

/// A mass at `at` on a spring of cubic force alone: the pair of contacts that it is made of.
NetworkElements cubic_spring(double stiffness, double at) {
  NetworkElements elements;
  elements.points = {mass(kMass, at), {Point::Kind::Ground, 0, 0, 0, {}}};
  elements.contacts = {contact(0, 1, stiffness, 3.0), contact(1, 0, stiffness, 3.0)};
  return elements;
}

const SolverBounds& of(const SolverChoice& choice, Solver solver) {
  return *std::find_if(choice.candidates.begin(), choice.candidates.end(),
                       [&](const auto& b) { return b.solver == solver; });
}

/// The largest energy in 20000 steps, against that of the start.
double growth(const NetworkElements& elements, Solver solver) {
  const auto network = Network::make(elements, 0, Hertz{kRate}, solver, 1).value();
  auto state = network.initial_state();
  const double start = network.energy(state);
  double most = start;
  for (int i = 0; i < 20000 && std::isfinite(most); ++i) {
    network.step(state, nullptr);
    const double now = network.energy(state);
    most = now <= most ? most : now;
  }
  return most / start;
}

}  // namespace

TEST_CASE("contact demand: a cubic spring is as stiff as the start can press it", "[physics]") {
  // K n^4 / 4 = K a^4 / 4 + m v^2 / 2 with v = 1 m/s;  k = 3 K n^2, once for both sides.
  const double stiffness = 1e12, at = 2e-3;
  const double depth = std::pow(std::pow(at, 4) + 2.0 * kMass / stiffness, 0.25);
  const auto demand = contact_demand(cubic_spring(stiffness, at));
  CHECK(demand.stiffness == Approx(3.0 * stiffness * depth * depth / kMass).epsilon(1e-12));
  // Half a swing: pi / (0.8472130848 a sqrt(K / m)).
  REQUIRE(demand.strikes.size() == 1);
  CHECK(demand.strikes[0].time_s ==
        Approx(std::numbers::pi / (0.8472130848 * at * std::sqrt(stiffness / kMass))).epsilon(1e-9));
}

TEST_CASE("contact demand: a heavy body presses what a light one cannot", "[physics]") {
  // All of M v^2 / 2 in the spring of the light one: k = 3 K n^2 = 6 sqrt(K E).
  auto elements = cubic_spring(1e9, 0.0);
  const double light = contact_demand(elements).stiffness;
  CHECK(light == Approx(6.0 * std::sqrt(1e9 * 0.5 * kMass) / kMass).epsilon(1e-12));
  elements.points.push_back(mass(100.0 * kMass));
  CHECK(contact_demand(elements).stiffness == Approx(10.0 * light).epsilon(1e-12));
}

TEST_CASE("contact demand: losses damp by r times the push, plectra by what they are", "[physics]") {
  // A linear contact at 1 m/s: F = sqrt(K m) v.
  NetworkElements elements;
  elements.points = {mass(kMass), {Point::Kind::Ground, 0, 0, 0, {}}};
  elements.contacts = {contact(0, 1, 4e3, 1.0)};
  elements.contacts[0].loss = 0.5;
  CHECK(contact_demand(elements).damping == Approx(0.5 * std::sqrt(4e3 * kMass) / kMass).epsilon(1e-12));
  elements.contacts.clear();
  elements.bonds = {
      {.lower = 0, .upper = 1, .law = std::make_shared<LinearBond>(5e3), .damping = 0.2, .limit = 1.0}};
  CHECK(contact_demand(elements).stiffness == Approx(5e3 / kMass).epsilon(1e-12));
  CHECK(contact_demand(elements).damping == Approx(0.2 / kMass).epsilon(1e-12));
}

TEST_CASE("contact demand: explicit steps are refused where the start would make them explode", "[physics]") {
  // k^2 3 K n^2 / m = 1.6 at n = 1.1085 mm, 0.3775 J, of which the strike at 1 m/s is 0.5 mJ.
  const double stiffness = 1e12;
  const double n_squared = kStiffestContact * kMass * kRate * kRate / (3.0 * stiffness);
  const double border = std::pow(n_squared * n_squared - 2.0 * kMass / stiffness, 0.25);
  const auto below = cubic_spring(stiffness, 0.99 * border), above = cubic_spring(stiffness, 1.01 * border);
  CHECK(of(choose_solver(below, Hertz{kRate}, 1), Solver::Explicit).stable);
  CHECK(growth(below, Solver::Explicit) < 2.0);
  CHECK(of(choose_solver(above, Hertz{kRate}, 1), Solver::Explicit).limit ==
        SolverBounds::Limit::DeepContact);
  // x+ = 2 x - x- - (k^2 K / m) x^3 leaves every bound from twice as far on.
  const auto far = cubic_spring(stiffness, 2.0 * border);
  CHECK_FALSE(growth(far, Solver::Explicit) < 1e6);
  const auto chosen = choose_solver(far, Hertz{kRate}, 1).solver;
  CHECK(chosen != Solver::Explicit);
  CHECK(growth(far, chosen) == Approx(1.0).margin(1e-9));
}

TEST_CASE("contact demand: a contact is off by no more than predicted, whatever its exponent", "[physics]") {
  // Where it is when it has left, against the closed form, over 40 phases of the touch between two frames.
  const double exponent = GENERATE(1.0, 1.5, 3.0, 10.0), steps = 13.5;
  const auto solver = GENERATE(Solver::Explicit, Solver::Passive, Solver::Exact, Solver::Implicit);
  const double a1 = exponent + 1.0, time = steps / kRate;
  const double depth =
      time / (2.0 * std::sqrt(std::numbers::pi) * std::tgamma(1.0 + 1.0 / a1) / std::tgamma(0.5 + 1.0 / a1));
  NetworkElements elements;
  elements.points = {mass(kMass), {Point::Kind::Ground, 0, 0, 0, {}}};
  elements.contacts = {contact(1, 0, 0.5 * a1 * kMass / std::pow(depth, a1), exponent)};
  const auto choice = choose_solver(elements, Hertz{kRate}, 1);
  const auto& predicted = of(choice, solver);
  CHECK(predicted.contact_steps == Approx(steps).epsilon(1e-9));
  REQUIRE(predicted.stable);
  double worst = 0.0;
  for (int phase = 0; phase < 40; ++phase) {
    const double before = (3.0 + phase / 40.0) / kRate;
    elements.points[0].position = before;
    elements.points[0].velocity = -1.0;
    const auto network = Network::make(elements, 0, Hertz{kRate}, solver, 1).value();
    auto state = network.initial_state();
    constexpr int kFrames = 20;
    for (int i = 0; i < kFrames; ++i) network.step(state, nullptr);
    worst = std::max(worst, std::abs(network.position(state, 0) - (kFrames / kRate - before - time)) / time);
  }
  CHECK(worst <= predicted.error);
  CHECK(worst > 0.1 * predicted.error);
}

TEST_CASE("contact demand: one with loss is off by no more than predicted, short ones too", "[physics]") {
  // Its speed, and the way it has gone by the instant it leaves, against the motion itself, over 10 phases.
  const double restitution = GENERATE(0.8, 0.2, 0.02), steps = GENERATE(0.3, 1.5, 7.0, 40.0);
  const auto solver = GENERATE(Solver::Explicit, Solver::Passive, Solver::Exact, Solver::Implicit);
  CAPTURE(restitution, steps, solver);
  const double exponent = 1.5, a1 = exponent + 1.0, time = steps / kRate;
  const double depth =
      time / (2.0 * std::sqrt(std::numbers::pi) * std::tgamma(1.0 + 1.0 / a1) / std::tgamma(0.5 + 1.0 / a1));
  NetworkElements elements;
  elements.points = {mass(kMass), {Point::Kind::Ground, 0, 0, 0, {}}};
  elements.contacts = {contact(1, 0, 0.5 * a1 * kMass / std::pow(depth, a1), exponent)};
  elements.contacts[0].restitution = restitution;
  const auto choice = choose_solver(elements, Hertz{kRate}, 1);
  const auto& predicted = of(choice, solver);
  if (!predicted.stable || predicted.error >= 0.4) return;  // it says that it is not right
  double speed_error = 0.0, way_error = 0.0;
  for (int phase = 0; phase < 10; ++phase) {
    elements.points[0].position = (3.0 + phase / 10.0) / kRate;
    elements.points[0].velocity = -1.0;
    const int frames = static_cast<int>(10 + 25 * steps);
    const auto arrive = [&](Solver with) {
      const auto network = Network::make(elements, 0, Hertz{kRate}, with, 1).value();
      auto state = network.initial_state();
      for (int i = 0; i < frames; ++i) network.step(state, nullptr);
      const double speed = network.velocity(state, 0);
      return std::pair{speed, frames / kRate - network.position(state, 0) / speed};
    };
    const auto [speed, left] = arrive(solver);
    const auto [right_speed, right_left] = arrive(Solver::Reference);
    CHECK(right_speed == Approx(restitution).epsilon(1e-6));
    speed_error = std::max(speed_error, std::abs(speed - restitution));
    way_error = std::max(way_error, restitution * std::abs(left - right_left));
  }
  CHECK(speed_error <= std::max(predicted.error, 1e-4));
  CHECK(way_error <= std::max(predicted.error * time, predicted.contact_frames / kRate));
}
