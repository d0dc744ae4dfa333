#include "engine/physics/solvers/solver_choice.h"

#include <algorithm>
#include <cmath>
#include <complex>
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
  int axes = 1;
};

class Demand {
 public:
  explicit Demand(const NetworkElements& elements) : elements_(elements) {}

  ContactDemand compute() {
    for (const auto& contact : elements_.contacts) add_strike(contact);
    for (const auto& contact : elements_.contacts) add_pressed(contact);
    auto contacts = std::exchange(links_, {});
    for (const auto& bond : elements_.bonds)
      links_.push_back({bond.lower, bond.upper, 0.0, bond.law->largest_stiffness(), bond.damping, bond.axes});
    demand_.bond_stiffness = largest(&Link::stiffness);
    demand_.bond_damping = largest(&Link::damping);
    const auto plain = [](const Link& link) { return link.axes == 1; };
    auto bonds = links_;
    std::erase_if(links_, plain);
    demand_.line_damping = largest(&Link::damping);
    links_ = std::move(bonds);
    links_.insert(links_.end(), contacts.begin(), contacts.end());
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
      if (!driven(s.lower, s.upper)) sum += 0.5 * s.stiffness * square(extension(places_, s));
    for (const auto& contact : elements_.contacts) sum += stored(contact);
    for (const auto& bond : elements_.bonds) {
      if (bond.axes == 1)
        sum += bond.law->largest_energy(bond.limit);
      else if (!driven(bond.lower, bond.upper))
        sum += bond.law->energy(stretch(places_, bond));
    }
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
    const double e = restitution(contact, v);
    const bool spring = springs_back(contact), pressed = e < 1.0 && stored(contact) > 0.0;
    const auto known = std::ranges::find_if(demand_.strikes, [&](const auto& strike) {
      return strike.exponent == contact.exponent && strike.restitution == e && strike.spring == spring &&
             strike.pressed == pressed;
    });
    if (known == demand_.strikes.end())
      demand_.strikes.push_back({contact.exponent, e, time, spring, pressed});
    else
      known->time_s = std::min(known->time_s, time);
  }

  /// Of the speeds, where a loss must not depend on the speed, or at that of the strike.
  static double restitution(const Contact& contact, double speed) {
    return contact.restitution ? *contact.restitution : restitution_of(contact.loss * speed);
  }
  /// Another contact pushes the other way as soon as this one opens: together they are a spring.
  bool springs_back(const Contact& contact) const {
    return std::ranges::any_of(elements_.contacts, [&](const Contact& other) {
      return other.lower == contact.upper && other.upper == contact.lower &&
             other.offset + contact.offset >= 0.0;
    });
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
  /// the sum of a row of that is D_lower / m_lower + D_upper / m_upper, D what all links put on a point. A
  /// link along a line is bounded by as stiff a one in each of its axes, and meets the links of all of them.
  double largest(double Link::*of) const {
    std::vector<double> on(elements_.points.size()), line_on(elements_.points.size());
    for (const auto& link : links_)
      for (int a = 0; a < link.axes; ++a)
        for (const int end : {link.lower + a, link.upper + a})
          (link.axes > 1 ? line_on : on)[index(end)] += link.*of;
    const auto at = [&](const Link& link, int end) {
      double sum = line_on[index(end)];
      for (int a = 0; a < link.axes; ++a) sum += on[index(end + a)];
      return sum * lightness(end);
    };
    double most = 0.0;
    for (const auto& link : links_) most = std::max(most, at(link, link.lower) + at(link, link.upper));
    return most;
  }

  static std::vector<double> places_of(const NetworkElements& elements) {
    std::vector<double> places;
    for (const auto& point : elements.points) places.push_back(point.position);
    return places;
  }

  const NetworkElements& elements_;
  const std::vector<double> places_ = places_of(elements_);
  const double energy_ = energy();
  ContactDemand demand_;
  std::vector<Link> links_;
  std::map<std::pair<int, int>, std::size_t> latest_;  ///< of the contacts of two points: which link
};

// Bounds do not depend on what enters.
constexpr int kSignals = 0;

/// Of x^2 - 2 half x + product = 0, half <= 0. Of two real ones the lower belongs to what decays faster.
struct Roots {
  Roots(double half, double product) {
    const double apart = half * half - product;
    real = apart >= 0.0;
    fast = real ? half - std::sqrt(apart) : Complex{half, -std::sqrt(-apart)};
    slow = real ? Complex{fast == 0.0 ? 0.0 : product / fast.real()} : std::conj(fast);
  }
  using Complex = std::complex<double>;
  Complex fast, slow;
  bool real;
};

/// The largest difference between e^(-right n) and (1 + w)^n for whole n.
double decay_error(double right, double w) {
  if (w <= -1.0) return std::abs(std::exp(-right) - (1.0 + w));
  const double stepped = -std::log1p(w);
  if (stepped == right) return 0.0;
  const double n = std::max(1.0, right > 0.0 ? std::log(stepped / right) / (stepped - right) : 1.0);
  return std::abs(std::exp(-right * n) - std::exp(-stepped * n));
}

std::complex<double> log_of_one_plus(std::complex<double> w) {
  return {0.5 * std::log1p(2.0 * w.real() + std::norm(w)), std::atan2(w.imag(), 1.0 + w.real())};
}

/// Of the time of a contact that lasts `s` steps.
double time_error(Solver solver, const ContactDemand::Strike& strike, double s) {
  const double a = strike.exponent, second_order = 0.5 + 0.33 * a, loss = 1.0 - strike.restitution;
  switch (solver) {
    case Solver::Implicit:
      return (loss > 0.0 ? 1.3 : 1.0) * (1.3 + 0.86 * a) / (s * s);
    case Solver::Passive:
      return std::max(1.0, 0.12 * a) / std::pow(s, 1.5);
    case Solver::Explicit:
      return std::max(1.4, second_order) / (s * s) + 0.45 * std::min(1.0, 2.8 * loss) / s;
    default:
      return second_order / (s * s);
  }
}

/// Of the speed at which the bodies part, relative to that at which they met.
double restitution_error(Solver solver, const ContactDemand::Strike& strike, double s) {
  constexpr double kWithinStep = 2.0, kSmall = 0.05;
  const double e = strike.restitution;
  if (e == 1.0) return 0.0;  // energy is kept (explicit: `kFewestContactSteps`)
  if (solver == Solver::Explicit) return s < 5.0 / std::sqrt(e) ? 1.0 : 1.0 / (s * s);
  if (s <= kWithinStep) return 0.0;
  if (s < std::max(5.0, 1.6 / std::sqrt(e))) return 0.4;
  const double error = 0.65 / (s * s);
  if (e >= kSmall) return error;
  if (solver == Solver::Implicit) return s < 20.0 ? 0.1 : error;
  return std::max(0.13, error);
}

/// Of the time of a contact shorter than `kShortContact`. [steps]
double short_contact_steps(Solver solver) {
  return solver == Solver::Exact ? 7.0 : solver == Solver::Implicit ? 4.0 : 2.0;
}

/// Of the current of a coil, whose own time is L / R.
double coil_error(Solver solver, const Coil& coil, double k) {
  if (solver == Solver::Exact || coil.inductance == 0.0) return 0.0;
  const double x = coil.resistance * k / coil.inductance, late = std::min(1.0, 2.0 / x);
  return x < 2.0 ? std::min(late, 2.0 * std::atanh(0.5 * x) / x - 1.0) : late;
}

Stepping stepping_of(Solver solver, bool averaged) {
  if (solver == Solver::Exact) return Stepping::Exact;
  if (solver == Solver::Explicit) return Stepping::Explicit;
  return averaged ? Stepping::Averaged : Stepping::Centred;
}

/// The largest of all oscillators up to a stiffness and a damping: nothing else is known of how they combine.
double largest_error(Stepping stepping, double square, double damping) {
  constexpr int kParts = 4;
  double worst = 0.0;
  for (int i = 0; i <= kParts; ++i)
    for (int j = 0; j <= kParts; ++j)
      worst = std::max(worst, oscillator_error(stepping, square * i / kParts, damping * j / kParts));
  return worst;
}

/// What springs, dampers, ports, coils and bonds are off by.
double linear_error(const NetworkElements& elements, const NetworkModel& model, const Network& network,
                    const ContactDemand& contacts) {
  const auto solver = network.solver();
  const double k = model.k, squared = k * k, damping = squared * model.stiffest(0.0, 1.0);
  double error = largest_error(stepping_of(solver, network.springs_averaged()),
                               squared * model.stiffest(1.0, 0.0), damping);
  if (!elements.bonds.empty())
    error = std::max(error, largest_error(Stepping::Averaged, squared * contacts.bond_stiffness, 0.0));
  if (const double z = k * contacts.line_damping; z > 0.0) {
    const auto stepping = solver == Solver::Explicit ? Stepping::Explicit : Stepping::Averaged;
    const bool rings = solver != Solver::Explicit && z > kStopsWithinStep;
    error = std::max(error, rings ? 1.0 : largest_error(stepping, squared * contacts.bond_stiffness, z));
  }
  for (const auto& coil : elements.coils) error = std::max(error, coil_error(solver, coil, k));
  const bool late = !elements.ports.empty() && damping > kStopsWithinStep && solver != Solver::Exact;
  return late ? std::max(error, 1.0) : error;
}

bool is_short(const ContactDemand::Strike& strike, double steps, int oversample) {
  return steps < kShortContact * oversample && !strike.spring;
}

void add_contacts(SolverBounds& bounds, const ContactDemand& contacts, double k) {
  for (const auto& strike : contacts.strikes) {
    const double steps = strike.time_s / k;
    bounds.contact_steps = bounds.contact_steps == 0.0 ? steps : std::min(bounds.contact_steps, steps);
    bounds.error = std::max(bounds.error, restitution_error(bounds.solver, strike, steps));
    if (!is_short(strike, steps, bounds.oversample) || bounds.solver == Solver::Explicit)
      bounds.error = std::max(bounds.error, time_error(bounds.solver, strike, steps));
    else
      bounds.contact_frames = short_contact_steps(bounds.solver) / bounds.oversample;
    bounds.opens_unknown |= strike.pressed && is_short(strike, steps, bounds.oversample);
  }
}

void add_slips(SolverBounds& bounds, const NetworkElements& elements, const NetworkModel& model,
               const ContactDemand& contacts) {
  const bool plectra = std::ranges::any_of(elements.bonds, &Bond::slips);
  if (elements.frictions.empty() && !plectra) return;
  const double k = model.k, squared = k * k;
  double fastest = std::max(std::sqrt(squared * std::max(model.stiffest(1.0, 0.0), contacts.bond_stiffness)),
                            squared * model.stiffest(0.0, 1.0));
  for (const auto& strike : contacts.strikes) {
    const double steps = strike.time_s / k;
    if (!is_short(strike, steps, bounds.oversample)) fastest = std::max(fastest, std::numbers::pi / steps);
  }
  if (plectra) fastest = std::max(fastest, k * contacts.bond_damping);
  const bool pressed = std::ranges::any_of(elements.frictions, [&](const Friction& friction) {
    return friction.normal_contact >= 0 && bounds.contact_frames > 0.0;
  });
  bounds.slips_unknown = fastest > kFastestLoad || pressed;
  if (bounds.slips_unknown) return;
  bounds.slip_error = square(fastest) / 8.0;
  bounds.slip_frames = 2.0 / bounds.oversample + bounds.contact_frames;
}

/// What makes explicit steps unstable.
SolverBounds::Limit explicit_limit(const NetworkModel& model, const ContactDemand& contacts) {
  using Limit = SolverBounds::Limit;
  const double squared = model.k * model.k, linear = squared * model.stiffest(1.0, 2.0);
  const double pressed = squared * contacts.stiffness;
  if (!(linear < 4.0)) return Limit::TooStiff;
  for (const auto& strike : contacts.strikes)
    if (strike.time_s / model.k < strike.fewest_steps()) return Limit::ShortContact;
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
  bounds.error = linear_error(elements, model, *made, contacts);
  add_contacts(bounds, contacts, k);
  add_slips(bounds, elements, model, contacts);
  if (solver == Solver::Explicit) bounds.limit = explicit_limit(model, contacts);
  if (bounds.limit == Limit::None && !(bounds.error <= kGoodEnough)) bounds.limit = Limit::Inexact;
  bounds.stable = bounds.limit == Limit::None || bounds.limit == Limit::Inexact;
  return bounds;
}

}  // namespace

double ContactDemand::Strike::fewest_steps() const {
  return std::max(kFewestContactSteps, 2.5 / std::sqrt(restitution));
}

double oscillator_error(Stepping stepping, double square, double damping) {
  if (stepping == Stepping::Exact || (square == 0.0 && damping == 0.0)) return 0.0;
  // a w^2 + (w_0^2 k^2 + c k) w + w_0^2 k^2 = 0,  z = 1 + w
  double a = 1.0;
  if (stepping != Stepping::Explicit) a += 0.5 * damping + stiff_weight(damping) * damping;
  if (stepping == Stepping::Averaged) a += 0.25 * square;
  const Roots step{-0.5 * (square + damping) / a, square / a};
  // s^2 + c k s + w_0^2 k^2 = 0
  const Roots motion{-0.5 * damping, square};
  if (step.real && motion.real) {
    const auto error = [](auto s, auto w) { return decay_error(-s.real(), w.real()); };
    return std::min(1.0, std::max(error(motion.fast, step.fast), error(motion.slow, step.slow)));
  }
  if (!(damping < a) || (step.real && step.fast.real() <= -1.0)) return 1.0;  // it swings at half the rate
  const double decay = damping == 0.0 ? 0.0 : std::abs(-std::log1p(-damping / a) / damping - 1.0);
  const auto logarithms = log_of_one_plus(step.fast) * log_of_one_plus(step.slow);
  return std::min(1.0, std::max(decay, std::abs(std::sqrt(logarithms.real() / square) - 1.0)));
}

ContactDemand contact_demand(const NetworkElements& elements) { return Demand{elements}.compute(); }

SolverChoice choose_solver(const NetworkElements& elements, Hertz rate, int oversample) {
  const auto contacts = contact_demand(elements);
  SolverChoice choice;
  const auto try_at = [&](int steps) {
    for (const auto solver : {Solver::Explicit, Solver::Passive, Solver::Exact, Solver::Implicit})
      choice.candidates.push_back(bounds_of(elements, rate, solver, steps, contacts));
  };
  const auto good = [](const SolverBounds& b) { return b.limit == SolverBounds::Limit::None; };
  const auto bounded = [&](const SolverBounds& b) { return good(b) && b.bounded(); };
  // A solver costs in proportion to its steps: twice as many are tried while the cheapest of those just tried
  // would still cost less than the best so far, or no more than its bound is worth.
  constexpr double kNone = std::numeric_limits<double>::infinity();
  double best_cost = kNone, bounded_cost = kNone;
  for (int steps = std::max(1, oversample); steps <= kMostOversample; steps *= 2) {
    const auto first = std::ssize(choice.candidates);
    try_at(steps);
    double least = kNone;
    for (auto b = choice.candidates.begin() + first; b != choice.candidates.end(); ++b) {
      if (b->limit != SolverBounds::Limit::CannotBeMade) least = std::min(least, b->multiplications);
      if (good(*b)) best_cost = std::min(best_cost, b->multiplications);
      if (bounded(*b)) bounded_cost = std::min(bounded_cost, b->multiplications);
    }
    const bool cheaper = 2.0 * least < best_cost;
    const bool worth = 2.0 * least < bounded_cost && 2.0 * least <= kBoundIsWorth * best_cost;
    if (oversample > 0 || !(cheaper || worth)) break;
  }
  std::stable_sort(choice.candidates.begin(), choice.candidates.end(),
                   [](const auto& a, const auto& b) { return a.multiplications < b.multiplications; });
  const SolverBounds* best = nullptr;
  for (const auto& b : choice.candidates) {
    if (!b.stable) continue;
    if (best == nullptr || (!good(*best) && b.error < best->error)) best = &b;
  }
  if (best == nullptr) return choice;  // none can be made: the passive solver reports the error
  const auto sure = std::ranges::find_if(choice.candidates, bounded);
  if (good(*best) && sure != choice.candidates.end() &&
      sure->multiplications <= kBoundIsWorth * best->multiplications)
    best = &*sure;
  choice.solver = best->solver;
  choice.oversample = best->oversample;
  return choice;
}

}  // namespace tactus
