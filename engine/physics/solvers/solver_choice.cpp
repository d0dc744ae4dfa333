#include "engine/physics/solvers/solver_choice.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <utility>

#include "engine/core/index.h"
#include "engine/physics/network.h"
#include "engine/physics/numbers.h"

namespace tactus {
namespace {

/// A contact or a bond, as far as it may be pressed or bent.
struct Link {
  int lower, upper;
  double offset, stiffness, damping;
};

class Demand {
 public:
  explicit Demand(const NetworkElements& elements) : elements_(elements) {}

  ContactDemand compute() {
    for (const auto& contact : elements_.contacts) add_strike(contact);
    for (const auto& contact : elements_.contacts) add_pressed(contact);
    for (const auto& bond : elements_.bonds)
      links_.push_back({bond.lower, bond.upper, 0.0, bond.law->largest_stiffness(), bond.damping});
    demand_.stiffness = largest(&Link::stiffness);
    demand_.damping = largest(&Link::damping);
    return std::move(demand_);
  }

 private:
  const Point& point(int at) const { return elements_.points[index(at)]; }
  double lightness(int at) const { return point(at).kind == Point::Kind::Mass ? 1.0 / point(at).mass : 0.0; }
  double apart(int lower, int upper) const { return point(lower).position - point(upper).position; }
  /// The position of a driven point is not known in advance: it is assumed to deform nothing.
  bool driven(int one, int other) const {
    return point(one).kind == Point::Kind::Motion || point(other).kind == Point::Kind::Motion;
  }
  double stored(const Contact& contact) const {
    const double n = apart(contact.lower, contact.upper) + contact.offset;
    if (n <= 0.0 || driven(contact.lower, contact.upper)) return 0.0;
    return ContactLaw(contact.stiffness, contact.exponent).energy(n);
  }

  /// What the network starts with, and the heaviest body at `kHardestStrike`. A bond holds all that
  /// it can.
  double energy() const {
    double sum = 0.0, heaviest = 0.0;
    for (const auto& p : elements_.points) {
      if (p.kind != Point::Kind::Mass) continue;
      sum += 0.5 * p.mass * square(p.velocity);
      heaviest = std::max(heaviest, p.mass);
    }
    for (const auto& s : elements_.springs)
      if (!driven(s.lower, s.upper)) sum += 0.5 * s.stiffness * square(apart(s.upper, s.lower) - s.rest);
    for (const auto& contact : elements_.contacts) sum += stored(contact);
    for (const auto& bond : elements_.bonds) sum += bond.law->largest_energy(bond.limit);
    return sum + 0.5 * heaviest * square(kHardestStrike);
  }

  void add_strike(const Contact& contact) {
    const double light = lightness(contact.lower) + lightness(contact.upper);
    if (light == 0.0) return;
    const double at_start = square(point(contact.lower).velocity - point(contact.upper).velocity);
    const double v = std::sqrt(std::max(square(kHardestStrike), at_start + 2.0 * light * stored(contact)));
    const double a1 = contact.exponent + 1.0;
    const double depth = std::pow(a1 * v * v / (2.0 * contact.stiffness * light), 1.0 / a1);
    const double time = 2.0 * std::sqrt(std::numbers::pi) * std::tgamma(1.0 + 1.0 / a1) /
                        std::tgamma(0.5 + 1.0 / a1) * depth / v;
    const auto known = std::find_if(demand_.strikes.begin(), demand_.strikes.end(),
                                    [&](const auto& strike) { return strike.exponent == contact.exponent; });
    if (known == demand_.strikes.end())
      demand_.strikes.push_back({contact.exponent, time});
    else
      known->time_s = std::min(known->time_s, time);
  }

  void add_pressed(const Contact& c) {
    const ContactLaw law(c.stiffness, c.exponent);
    const double depth = std::pow((c.exponent + 1.0) * energy_ / c.stiffness, 1.0 / (c.exponent + 1.0));
    const double loss = c.restitution ? loss_for_restitution(*c.restitution) / kHardestStrike : c.loss;
    const Link link{c.lower, c.upper, c.offset, law.stiffness(depth), loss * law.force(depth)};
    const auto against = latest_.find({c.upper, c.lower});
    if (against != latest_.end() && links_[against->second].offset + c.offset <= 0.0) {
      auto& other = links_[against->second];
      other.stiffness = std::max(other.stiffness, link.stiffness);
      other.damping = std::max(other.damping, link.damping);
      latest_.erase(against);
    } else {
      latest_[{c.lower, c.upper}] = links_.size();
      links_.push_back(link);
    }
  }

  /// Of links b_e w_e b_e^T over masses: M^-1 B W B^T has the eigenvalues of B^T M^-1 B W but for zeros, and
  /// the sum of a row of that is D_lower / m_lower + D_upper / m_upper, D what all links put on a point.
  double largest(double Link::*of) const {
    std::vector<double> on(elements_.points.size());
    for (const auto& link : links_) on[index(link.lower)] += link.*of, on[index(link.upper)] += link.*of;
    double most = 0.0;
    for (const auto& link : links_)
      most = std::max(most, on[index(link.lower)] * lightness(link.lower) +
                                on[index(link.upper)] * lightness(link.upper));
    return most;
  }

  const NetworkElements& elements_;
  const double energy_ = energy();
  ContactDemand demand_;
  std::vector<Link> links_;
  std::map<std::pair<int, int>, std::size_t> latest_;  ///< of the contacts of two points: which link
};

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

ContactDemand contact_demand(const NetworkElements& elements) { return Demand{elements}.compute(); }

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
