#include "engine/physics/solvers/solver_choice.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/physics/network.h"

namespace tactus {
namespace {

// Bounds do not depend on what enters.
constexpr int kSignals = 0;

double contact_error(Solver solver, const ContactDemand::Strike& strike, double k) {
  const double a = strike.exponent, s = strike.time_s / k, second_order = 0.5 + 0.33 * a;
  switch (solver) {
    case Solver::Implicit:
      return (1.3 + 0.86 * a) / (s * s);
    case Solver::Passive:
      return std::max(1.0, 0.12 * a) / std::pow(s, 1.5);
    case Solver::Explicit:
      return std::max(1.4, second_order) / (s * s);
    default:
      return second_order / (s * s);
  }
}

/// What makes explicit steps unstable.
SolverBounds::Limit explicit_limit(const NetworkModel& model, const ContactDemand& contacts,
                                   const SolverBounds& bounds) {
  using Limit = SolverBounds::Limit;
  const double squared = model.k * model.k, linear = squared * model.stiffest(1.0, 2.0);
  const double pressed = squared * contacts.stiffness;
  if (!(linear < 4.0)) return Limit::TooStiff;
  if (!contacts.strikes.empty() && bounds.contact_steps < kFewestContactSteps) return Limit::ShortContact;
  const double all = linear + pressed + 2.0 * model.k * contacts.damping;
  return all < 4.0 && pressed <= kStiffestContact ? Limit::None : Limit::DeepContact;
}

SolverBounds bounds_of(const NetworkElements& elements, Hertz rate, Solver solver, int oversample,
                       const ContactDemand& contacts) {
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
  const auto cost = made->network_solver().cost();
  bounds.multiplications = oversample * (cost.step + (elements.contacts.empty() ? 0.0 : cost.contact));
  const double shape = made->springs_averaged() ? 12.0 : 24.0;
  bounds.error = solver == Solver::Exact ? 0.0 : model.stiffest(1.0, 0.0) * k * k / shape;
  for (const auto& strike : contacts.strikes) {
    const double steps = strike.time_s / k;
    bounds.contact_steps = bounds.contact_steps == 0.0 ? steps : std::min(bounds.contact_steps, steps);
    bounds.error = std::max(bounds.error, contact_error(solver, strike, k));
  }
  if (solver == Solver::Explicit) bounds.limit = explicit_limit(model, contacts, bounds);
  if (bounds.limit == Limit::None && !(bounds.error <= kGoodEnough)) bounds.limit = Limit::Inexact;
  bounds.stable = bounds.limit == Limit::None || bounds.limit == Limit::Inexact;
  return bounds;
}

}  // namespace

SolverChoice choose_solver(const NetworkElements& elements, Hertz rate, int oversample) {
  const auto contacts = contact_demand(elements);
  SolverChoice choice;
  const auto try_at = [&](int steps) {
    for (const auto solver : {Solver::Explicit, Solver::Passive, Solver::Exact, Solver::Implicit})
      choice.candidates.push_back(bounds_of(elements, rate, solver, steps, contacts));
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
  if (best == nullptr) return choice;  // none can be made: the passive solver reports the error
  choice.solver = best->solver;
  choice.oversample = best->oversample;
  return choice;
}

}  // namespace tactus
