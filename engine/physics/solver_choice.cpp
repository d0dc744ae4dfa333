#include "engine/physics/solver_choice.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "engine/physics/network.h"

namespace tactus {
namespace {

constexpr int kMostOversample = 64;
// Bounds do not depend on what enters.
constexpr int kSignals = 0;

/// The shortest contact, alpha the exponent, m the reduced mass, v the speed of the strike:
///   t = 2 sqrt(pi) Gamma(1 + 1/(alpha+1)) / Gamma(1/2 + 1/(alpha+1)) * ((alpha+1) m v^2 / 2K)^(1/(alpha+1))
///   / v
std::optional<double> shortest_contact(const NetworkElements& elements) {
  const auto inverse_mass = [&](int point) {
    const auto& p = elements.points[static_cast<std::size_t>(point)];
    return p.kind == Point::Kind::Mass ? 1.0 / p.mass : 0.0;
  };
  std::optional<double> shortest;
  for (const auto& c : elements.contacts) {
    const double inverse = inverse_mass(c.lower) + inverse_mass(c.upper);
    if (inverse == 0.0) continue;
    const double a1 = c.exponent + 1.0, v = kHardestStrike;
    const double depth = std::pow(a1 * v * v / (2.0 * c.stiffness * inverse), 1.0 / a1);
    const double time = 2.0 * std::sqrt(std::numbers::pi) * std::tgamma(1.0 + 1.0 / a1) /
                        std::tgamma(0.5 + 1.0 / a1) * depth / v;
    shortest = std::min(shortest.value_or(time), time);
  }
  return shortest;
}

double contact_error(Solver solver, double steps) {
  switch (solver) {
    case Solver::Implicit:
      return 0.25 / steps;
    case Solver::Passive:
      return 1.0 / std::pow(steps, 1.5);
    default:
      return 1.4 / (steps * steps);
  }
}

SolverBounds bounds_of(const NetworkElements& elements, Hertz rate, Solver solver, int oversample,
                       std::optional<double> contact) {
  using Limit = SolverBounds::Limit;
  SolverBounds bounds{.solver = solver, .oversample = oversample};
  const auto made = Network::make(elements, kSignals, rate, solver, oversample);
  if (!made) {
    bounds.limit = Limit::CannotBeMade;
    bounds.error = std::numeric_limits<double>::infinity();
    return bounds;
  }
  const double k = 1.0 / (rate.value * oversample);
  const NetworkModel model(elements, kSignals, k);
  const auto cost = made->scheme().cost();
  bounds.multiplications = oversample * (cost.step + (elements.contacts.empty() ? 0.0 : cost.touch));
  const double shape = made->springs_averaged() ? 12.0 : 24.0;
  bounds.error = solver == Solver::Exact ? 0.0 : model.stiffest(1.0, 0.0) * k * k / shape;
  if (contact) {
    bounds.contact_steps = *contact / k;
    bounds.error = std::max(bounds.error, contact_error(solver, bounds.contact_steps));
  }
  if (solver == Solver::Explicit && !(model.stiffest(1.0, 2.0) * k * k < 4.0))
    bounds.limit = Limit::TooStiff;
  else if (solver == Solver::Explicit && contact && bounds.contact_steps < kFewestContactSteps)
    bounds.limit = Limit::ShortContact;
  else if (!(bounds.error <= kGoodEnough))
    bounds.limit = Limit::Inexact;
  bounds.stable = bounds.limit == Limit::None || bounds.limit == Limit::Inexact;
  return bounds;
}

}  // namespace

SolverChoice choose_solver(const NetworkElements& elements, Hertz rate, int oversample) {
  const auto contact = shortest_contact(elements);
  SolverChoice choice;
  const auto try_at = [&](int steps) {
    for (const auto solver : {Solver::Explicit, Solver::Passive, Solver::Exact, Solver::Implicit})
      choice.candidates.push_back(bounds_of(elements, rate, solver, steps, contact));
  };
  const auto good = [](const SolverBounds& b) { return b.limit == SolverBounds::Limit::None; };
  // More steps of a solver cost more: once one will do, twice as many can only be dearer than it.
  for (int steps = std::max(1, oversample); steps <= kMostOversample; steps *= 2) {
    try_at(steps);
    if (oversample > 0 || std::any_of(choice.candidates.begin(), choice.candidates.end(), good)) break;
  }
  std::stable_sort(choice.candidates.begin(), choice.candidates.end(),
                   [](const auto& a, const auto& b) { return a.multiplications < b.multiplications; });
  const SolverBounds* best = nullptr;
  for (const auto& b : choice.candidates) {
    if (!b.stable) continue;
    if (best == nullptr || (!good(*best) && b.error < best->error)) best = &b;
  }
  if (best == nullptr) return choice;  // nothing could be made: the passive solver will say why
  choice.solver = best->solver;
  choice.oversample = best->oversample;
  return choice;
}

}  // namespace tactus
