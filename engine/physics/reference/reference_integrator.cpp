#include "engine/physics/reference/reference_integrator.h"

#include <Eigen/Core>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <unsupported/Eigen/MatrixFunctions>
#include <utility>

#include "engine/core/find_root.h"
#include "engine/core/index.h"
#include "engine/physics/numbers.h"

namespace tactus {
namespace {

// Its exponential then takes a second; larger ones are integrated faster than multiplied.
constexpr std::size_t kMostExactNumbers = 256;

Eigen::Index row_of(std::size_t i) { return static_cast<Eigen::Index>(i); }

// A driven point changes its speed from frame to frame; less than this is rounding. [m/s]
constexpr double kStill = 1e-12;
// How far past a stop the law goes on. [m/s]
constexpr double kPast = 1e-3;

/// K n^a, and the same with its sign changed below 0: smooth there, as a step that runs past an opening
/// needs.
double odd_force(const ContactLaw& law, double n) { return n < 0.0 ? -law.force(-n) : law.force(n); }

/// matrix x = b for `n` unknowns, symmetric and positive (semi)definite; the result in `b`.
void solve(double* matrix, double* b, std::size_t n) {
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = i + 1; j < n; ++j) {
      const double share = matrix[i * n + i] > 0.0 ? matrix[j * n + i] / matrix[i * n + i] : 0.0;
      for (std::size_t l = i; l < n; ++l) matrix[j * n + l] -= share * matrix[i * n + l];
      b[j] -= share * b[i];
    }
  for (std::size_t i = n; i-- > 0;) {
    for (std::size_t l = i + 1; l < n; ++l) b[i] -= matrix[i * n + l] * b[l];
    b[i] = matrix[i * n + i] > 0.0 ? b[i] / matrix[i * n + i] : 0.0;
  }
}

// More in one frame: the motion cannot be followed.
constexpr int kMostSteps = 200'000;
// Of a frame: what is left of it is nothing.
constexpr double kNothing = 1e-13;
// Of a step: how closely an event is located.
constexpr double kInstant = 1e-14;
// Slower motion, nearer to 0, is as good as rest. [m], [m/s], [A]
constexpr double kLeastPosition = 1e-9, kLeastVelocity = 1e-6, kLeastCurrent = 1e-9;
// So many times the tolerance may be the rounding of large forces that balance.
constexpr double kMostRounding = 1e4;

double largest(const double* numbers, std::size_t count) {
  double most = 0.0;
  for (std::size_t i = 0; i < count; ++i)
    if (!(std::abs(numbers[i]) <= most)) most = std::abs(numbers[i]);  // NaN is the largest
  return most;
}

}  // namespace

ReferenceIntegrator::ReferenceIntegrator(NetworkElements elements, Seconds frame, double tolerance)
    : elements_(std::move(elements)), frame_s_(frame.value), tolerance_(tolerance) {
  assert(frame_s_ > 0.0);
  for (auto& coil : elements_.coils) {
    if (coil.against >= 0) continue;
    coil.against = static_cast<int>(elements_.points.size());
    elements_.points.emplace_back().kind = Point::Kind::Ground;
  }
  for (std::size_t i = 0; i < elements_.points.size(); ++i) {
    const auto& point = elements_.points[i];
    inverse_mass_.push_back(point.kind == Point::Kind::Mass ? 1.0 / point.mass : 0.0);
    if (point.kind == Point::Kind::Motion) driven_.push_back(static_cast<int>(i));
  }
  for (const auto& contact : elements_.contacts) {
    laws_.emplace_back(contact.stiffness, contact.exponent);
    loss_speed_.push_back(contact.restitution ? loss_for_restitution(*contact.restitution) : 0.0);
  }
  make_transition();
}

ReferenceIntegrator::State ReferenceIntegrator::initial(std::span<const double> motions) const {
  State state;
  state.numbers.resize(2 * points() + elements_.coils.size());
  state.next = state.slope = state.numbers;
  state.loss.resize(laws_.size());
  state.contacts.resize(laws_.size());
  state.slide.resize(elements_.frictions.size() + elements_.bonds.size());
  state.hold.resize(elements_.frictions.size());
  state.mutual.resize(elements_.frictions.size() * elements_.frictions.size());
  state.inputs.resize(held());
  if (!exact()) state.extrapolation = Extrapolation(state.numbers.size());
  reset(state, motions);
  return state;
}

void ReferenceIntegrator::reset(State& state, std::span<const double> motions) const {
  std::fill(state.numbers.begin(), state.numbers.end(), 0.0);
  std::fill(state.inputs.begin(), state.inputs.end(), 0.0);
  for (std::size_t i = 0; i < points(); ++i) {
    state.numbers[i] = elements_.points[i].position;
    if (inverse_mass_[i] > 0.0) state.numbers[points() + i] = elements_.points[i].velocity;
  }
  for (std::size_t i = 0; i < driven_.size() && i < motions.size(); ++i)
    state.numbers[index(driven_[i])] = motions[i];
  const double* numbers = state.numbers.data();
  for (std::size_t c = 0; c < laws_.size(); ++c)
    state.loss[c] = indentation_in(numbers, c) > 0.0 ? start_loss(c, approach_in(numbers, c)) : 0.0;
  find_contacts(state);
  std::fill(state.slide.begin(), state.slide.end(), 0.0);
  std::fill(state.hold.begin(), state.hold.end(), 0.0);
  state.step_s = 0.0;
}

void ReferenceIntegrator::find_contacts(State& state) const {
  const double* numbers = state.numbers.data();
  for (std::size_t c = 0; c < laws_.size(); ++c) {
    const bool pulls = 1.0 + state.loss[c] * approach_in(numbers, c) < 0.0;
    state.contacts[c] = !(indentation_in(numbers, c) > 0.0) ? ContactState::Open
                        : pulls                             ? ContactState::Releasing
                                                            : ContactState::Pressing;
  }
}

void ReferenceIntegrator::advance(State& state, const Inputs& inputs) const {
  double* held_now = state.inputs.data();
  const auto fill = [&held_now](std::span<const double> values, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) *held_now++ = i < values.size() ? values[i] : 0.0;
  };
  fill(inputs.forces, elements_.forces.size());
  fill(inputs.voltages, elements_.coils.size());
  fill(inputs.waves, elements_.ports.size());
  fill(inputs.normals, elements_.frictions.size());
  *held_now = 1.0;
  for (std::size_t i = 0; i < driven_.size(); ++i) {
    const auto point = index(driven_[i]);
    if (i < inputs.motion_from.size()) state.numbers[point] = inputs.motion_from[i];
    const double to = i < inputs.motion_to.size() ? inputs.motion_to[i] : state.numbers[point];
    state.numbers[points() + point] = (to - state.numbers[point]) / frame_s_;
  }
  if (exact())
    multiply(state);
  else
    integrate(state);
  for (std::size_t i = 0; i < driven_.size() && i < inputs.motion_to.size(); ++i)
    state.numbers[index(driven_[i])] = inputs.motion_to[i];
}

double ReferenceIntegrator::tension_in(const double* numbers, const Spring& spring) const {
  const double* velocities = numbers + points();
  return spring.stiffness * (numbers[spring.upper] - numbers[spring.lower] - spring.rest) +
         spring.damping * (velocities[spring.upper] - velocities[spring.lower]);
}

double ReferenceIntegrator::indentation_in(const double* numbers, std::size_t contact) const {
  const auto& c = elements_.contacts[contact];
  return numbers[c.lower] - numbers[c.upper] + c.offset;
}

double ReferenceIntegrator::approach_in(const double* numbers, std::size_t contact) const {
  const auto& c = elements_.contacts[contact];
  const double* velocities = numbers + points();
  return velocities[c.lower] - velocities[c.upper];
}

double ReferenceIntegrator::start_loss(std::size_t contact, double speed) const {
  constexpr double kSlowest_m_per_s = 1e-4;
  if (loss_speed_[contact] == 0.0) return elements_.contacts[contact].loss;
  return loss_speed_[contact] / std::max(speed, kSlowest_m_per_s);
}

/// Without an inductance the current follows the voltage at once.
double ReferenceIntegrator::current_in(const double* numbers, const double* voltages,
                                       std::size_t coil) const {
  const auto& c = elements_.coils[coil];
  if (c.inductance > 0.0) return numbers[2 * points() + coil];
  const double* velocities = numbers + points();
  return (voltages[coil] - c.force_factor * (velocities[c.on] - velocities[c.against])) / c.resistance;
}

void ReferenceIntegrator::rates(State& state, const double* numbers, double* slope) const {
  double* force = slope + points();
  std::copy_n(numbers + points(), points(), slope);
  std::fill_n(force, points(), 0.0);
  add_springs(numbers, force);
  add_contacts(state, numbers, force);
  add_held(state, numbers, force);
  add_coils(state, numbers, slope);
  add_slides(state, numbers, force);
  hold(state, force);
  for (std::size_t i = 0; i < points(); ++i) force[i] *= inverse_mass_[i];
}

void ReferenceIntegrator::add_springs(const double* numbers, double* force) const {
  for (const auto& s : elements_.springs) {
    const double tension = tension_in(numbers, s);
    force[s.lower] += tension;
    force[s.upper] -= tension;
  }
}

void ReferenceIntegrator::add_contacts(const State& state, const double* numbers, double* force) const {
  for (std::size_t c = 0; c < laws_.size(); ++c) {
    const double push = push_in(state, numbers, c);
    force[elements_.contacts[c].lower] -= push;
    force[elements_.contacts[c].upper] += push;
  }
}

/// What is held over a frame: forces, and waves with the impedance of their ports.
void ReferenceIntegrator::add_held(const State& state, const double* numbers, double* force) const {
  for (std::size_t i = 0; i < elements_.forces.size(); ++i) force[elements_.forces[i].on] += state.inputs[i];
  const double* waves = state.inputs.data() + elements_.forces.size() + elements_.coils.size();
  for (std::size_t i = 0; i < elements_.ports.size(); ++i) {
    const auto& port = elements_.ports[i];
    force[port.on] += 2.0 * waves[i] - port.impedance * numbers[points() + index(port.on)];
  }
}

void ReferenceIntegrator::add_coils(const State& state, const double* numbers, double* slope) const {
  const double* velocities = numbers + points();
  const double* voltages = state.inputs.data() + elements_.forces.size();
  double* force = slope + points();
  for (std::size_t i = 0; i < elements_.coils.size(); ++i) {
    const auto& coil = elements_.coils[i];
    const double current = current_in(numbers, voltages, i);
    force[coil.on] += coil.force_factor * current;
    force[coil.against] -= coil.force_factor * current;
    const double back = coil.force_factor * (velocities[coil.on] - velocities[coil.against]);
    slope[2 * points() + i] =
        coil.inductance > 0.0 ? (voltages[i] - coil.resistance * current - back) / coil.inductance : 0.0;
  }
}

double ReferenceIntegrator::position(const State& state, int point) const {
  return state.numbers[index(point)];
}

double ReferenceIntegrator::velocity(const State& state, int point) const {
  return state.numbers[points() + index(point)];
}

double ReferenceIntegrator::current(const State& state, int coil) const {
  return current_in(state.numbers.data(), state.inputs.data() + elements_.forces.size(), index(coil));
}

double ReferenceIntegrator::energy(const State& state) const {
  double sum = 0.0;
  for (std::size_t i = 0; i < points(); ++i)
    if (inverse_mass_[i] > 0.0) sum += 0.5 * elements_.points[i].mass * square(state.numbers[points() + i]);
  for (const auto& s : elements_.springs)
    sum += 0.5 * s.stiffness * square(position(state, s.upper) - position(state, s.lower) - s.rest);
  for (std::size_t c = 0; c < laws_.size(); ++c)
    if (const double n = indentation_in(state.numbers.data(), c); n > 0.0) sum += laws_[c].energy(n);
  for (std::size_t p = 0; p < elements_.bonds.size(); ++p)
    if (state.slide[elements_.frictions.size() + p] == 0.0)
      sum += elements_.bonds[p].law->energy(
          between(state.numbers.data(), elements_.bonds[p].lower, elements_.bonds[p].upper));
  for (std::size_t i = 0; i < elements_.coils.size(); ++i)
    sum += 0.5 * elements_.coils[i].inductance * square(current(state, static_cast<int>(i)));
  return sum;
}

struct ReferenceIntegrator::Transition {
  Eigen::MatrixXd matrix;  ///< from z to the numbers of the state
};

/// The columns of A are the rates of unit vectors. Velocities are counted in units that make the fastest
/// frequency 1, or the exponential would lose digits to large entries.
void ReferenceIntegrator::make_transition() {
  const auto numbers = 2 * points() + elements_.coils.size();
  const auto all = numbers + held();
  const bool linear = laws_.empty() && elements_.frictions.empty() && elements_.bonds.empty();
  if (!linear || all > kMostExactNumbers) return;
  double fastest = 1.0;
  for (const auto& s : elements_.springs)
    for (const int end : {s.lower, s.upper})
      fastest = std::fmax(fastest, std::sqrt(s.stiffness * inverse_mass_[index(end)]));
  Eigen::VectorXd unit = Eigen::VectorXd::Ones(row_of(all));
  unit.segment(row_of(points()), row_of(points())).setConstant(fastest);

  Eigen::MatrixXd a = Eigen::MatrixXd::Zero(row_of(all), row_of(all));
  State at_rest;
  at_rest.inputs.assign(held(), 0.0);
  std::vector<double> zero(numbers), constant(numbers), column(numbers);
  rates(at_rest, zero.data(), constant.data());
  for (std::size_t j = 0; j + 1 < all; ++j) {
    double& one = j < numbers ? zero[j] : at_rest.inputs[j - numbers];
    one = 1.0;
    rates(at_rest, zero.data(), column.data());
    one = 0.0;
    for (std::size_t i = 0; i < numbers; ++i) a(row_of(i), row_of(j)) = column[i] - constant[i];
  }
  for (std::size_t i = 0; i < numbers; ++i) a(row_of(i), row_of(all - 1)) = constant[i];
  const Eigen::MatrixXd scaled = frame_s_ * (unit.cwiseInverse().asDiagonal() * a * unit.asDiagonal()).eval();
  const Eigen::MatrixXd exponential =
      unit.asDiagonal() * Eigen::MatrixXd(scaled.exp()) * unit.cwiseInverse().asDiagonal();
  transition_ = std::make_shared<Transition>(Transition{exponential.topRows(row_of(numbers))});
}

void ReferenceIntegrator::multiply(State& state) const {
  const auto numbers = row_of(state.numbers.size()), inputs = row_of(state.inputs.size());
  Eigen::Map<Eigen::VectorXd> next(state.next.data(), numbers);
  next.noalias() = transition_->matrix.leftCols(numbers) *
                   Eigen::Map<const Eigen::VectorXd>(state.numbers.data(), numbers);
  next.noalias() +=
      transition_->matrix.rightCols(inputs) * Eigen::Map<const Eigen::VectorXd>(state.inputs.data(), inputs);
  state.numbers.swap(state.next);
}

double ReferenceIntegrator::between(const double* numbers, int lower, int upper) const {
  return numbers[lower] - numbers[upper];
}

double ReferenceIntegrator::push_in(const State& state, const double* numbers, std::size_t contact) const {
  if (state.contacts[contact] != ContactState::Pressing) return 0.0;
  return odd_force(laws_[contact], indentation_in(numbers, contact)) *
         (1.0 + state.loss[contact] * approach_in(numbers, contact));
}

double ReferenceIntegrator::normal_in(const State& state, const double* numbers, std::size_t friction) const {
  const auto& f = elements_.frictions[friction];
  if (f.normal_contact >= 0) return std::max(0.0, push_in(state, numbers, index(f.normal_contact)));
  if (f.normal_spring >= 0)
    return std::max(0.0, tension_in(numbers, elements_.springs[index(f.normal_spring)]));
  const auto first = held() - 1 - elements_.frictions.size();
  return std::max(0.0, state.inputs[first + friction]);
}

double ReferenceIntegrator::sliding_force(const State& state, const double* numbers, std::size_t friction,
                                          double sign) const {
  const auto& f = elements_.frictions[friction];
  const double v = between(numbers + points(), f.lower, f.upper);
  return sign * normal_in(state, numbers, friction) * f.law.coefficient(std::max(sign * v, -kPast)) +
         f.viscous * v;
}

double ReferenceIntegrator::bond_in(const State& state, const double* numbers, std::size_t bond) const {
  if (state.slide[elements_.frictions.size() + bond] != 0.0) return 0.0;
  const auto& b = elements_.bonds[bond];
  return b.law->force(between(numbers, b.lower, b.upper)) +
         b.damping * between(numbers + points(), b.lower, b.upper);
}

void ReferenceIntegrator::add_slides(const State& state, const double* numbers, double* force) const {
  const auto push = [force](const auto& link, double by) {
    force[link.lower] -= by;
    force[link.upper] += by;
  };
  for (std::size_t f = 0; f < elements_.frictions.size(); ++f)
    if (state.slide[f] != 0.0) push(elements_.frictions[f], sliding_force(state, numbers, f, state.slide[f]));
  for (std::size_t b = 0; b < elements_.bonds.size(); ++b)
    push(elements_.bonds[b], bond_in(state, numbers, b));
}

/// Adds the forces of the frictions that hold to those of all others: (x_lower - x_upper)'' = 0.
void ReferenceIntegrator::hold(State& state, double* force) const {
  const auto n = elements_.frictions.size();
  for (std::size_t i = 0; i < n; ++i) {
    const auto& a = elements_.frictions[i];
    const bool holds = state.slide[i] == 0.0;
    state.hold[i] = holds ? force[a.lower] * inverse_mass_[index(a.lower)] -
                                force[a.upper] * inverse_mass_[index(a.upper)]
                          : 0.0;
    for (std::size_t j = 0; j < n; ++j) {
      const auto& b = elements_.frictions[j];
      const auto share = [&](int of_a, int of_b) { return of_a == of_b ? inverse_mass_[index(of_a)] : 0.0; };
      const double mutual = share(a.lower, b.lower) + share(a.upper, b.upper) - share(a.lower, b.upper) -
                            share(a.upper, b.lower);
      state.mutual[i * n + j] = holds && state.slide[j] == 0.0 ? mutual : 0.0;
    }
  }
  solve(state.mutual.data(), state.hold.data(), n);
  for (std::size_t i = 0; i < n; ++i) {
    force[elements_.frictions[i].lower] -= state.hold[i];
    force[elements_.frictions[i].upper] += state.hold[i];
  }
}

/// At the start of a frame driven points have new speeds, which what held to them has not.
void ReferenceIntegrator::start_slides(State& state) const {
  for (std::size_t f = 0; f < elements_.frictions.size(); ++f) {
    const auto& friction = elements_.frictions[f];
    const double v = between(state.numbers.data() + points(), friction.lower, friction.upper);
    if (state.slide[f] == 0.0 && std::abs(v) > kStill) state.slide[f] = v > 0.0 ? 1.0 : -1.0;
  }
}

double ReferenceIntegrator::friction_margin(State& state, const double* numbers, std::size_t friction) const {
  const auto& f = elements_.frictions[friction];
  if (state.slide[friction] != 0.0) {
    const double v = between(numbers + points(), f.lower, f.upper);
    return state.slide[friction] * v;
  }
  rates(state, numbers, state.slope.data());
  return normal_in(state, numbers, friction) * f.law.holding() - std::abs(state.hold[friction]);
}

double ReferenceIntegrator::bond_margin(const State& state, const double* numbers, std::size_t bond) const {
  const auto& b = elements_.bonds[bond];
  const double n = between(numbers, b.lower, b.upper);
  const double slide = state.slide[elements_.frictions.size() + bond];
  return slide == 0.0 ? b.law->distance_at(b.limit) - std::abs(n) : slide * n;
}

/// Takes away what rounding has left of the velocity at a stop.
void ReferenceIntegrator::halt(State& state, std::size_t friction) const {
  const auto lower = index(elements_.frictions[friction].lower);
  const auto upper = index(elements_.frictions[friction].upper);
  double* velocities = state.numbers.data() + points();
  const double v = velocities[lower] - velocities[upper], light = inverse_mass_[lower] + inverse_mass_[upper];
  if (light == 0.0) return;
  velocities[lower] -= v * inverse_mass_[lower] / light;
  velocities[upper] += v * inverse_mass_[upper] / light;
}

/// One that slid has stopped: it holds if it can. One that cannot hold any longer slides.
void ReferenceIntegrator::switch_friction(State& state, std::size_t friction) const {
  halt(state, friction);
  state.slide[friction] = 0.0;
  if (friction_margin(state, state.numbers.data(), friction) < 0.0)
    state.slide[friction] = state.hold[friction] > 0.0 ? 1.0 : -1.0;
}

double ReferenceIntegrator::friction_velocity(const State& state, int friction) const {
  const auto& f = elements_.frictions[index(friction)];
  return between(state.numbers.data() + points(), f.lower, f.upper);
}

/// Of one that holds: the force at the end of the last step.
double ReferenceIntegrator::friction_force(const State& state, int friction) const {
  const auto f = index(friction);
  return state.slide[f] == 0.0 ? state.hold[f]
                               : sliding_force(state, state.numbers.data(), f, state.slide[f]);
}

void ReferenceIntegrator::integrate(State& state) const {
  double left_s = frame_s_;
  start_slides(state);
  for (int steps = 0; left_s > kNothing * frame_s_; ++steps) {
    double done_s = steps < kMostSteps ? try_step(state, left_s) : 0.0;
    if (done_s == 0.0)
      return std::fill(state.numbers.begin(), state.numbers.end(), std::numeric_limits<double>::quiet_NaN());
    done_s = until_event(state, until_turn(state, done_s));
    state.numbers.swap(state.next);
    left_s -= done_s;
    switch_over(state);
  }
}

/// The longest step that is good and not longer than `longest_s`, into `next`; 0: there is none.
double ReferenceIntegrator::try_step(State& state, double longest_s) const {
  const auto slope = [&](double, const double* numbers, double* to) { rates(state, numbers, to); };
  const auto worst = [&](const double* numbers, const double* difference) {
    return error(numbers, difference);
  };
  double seconds = state.step_s > 0.0 ? std::min(state.step_s, longest_s) : longest_s;
  const double wanted_s = state.step_s;
  double last_s = 0.0, last_error = 0.0;
  while (seconds > kNothing * kNothing * frame_s_) {
    const auto outcome = state.extrapolation.step(slope, state.numbers.data(), seconds, worst);
    state.step_s = outcome.advised_s;
    // What shrinks no faster than the step is no error of the method.
    const bool rounding =
        outcome.error < kMostRounding && outcome.error * last_s > 0.5 * last_error * seconds && last_s > 0.0;
    if (outcome.good || rounding) {
      // The end of a frame does not limit the next step.
      if (seconds == longest_s) state.step_s = std::max(state.step_s, wanted_s);
      state.next = state.extrapolation.result();
      return seconds;
    }
    last_s = std::exchange(seconds, outcome.advised_s);
    last_error = outcome.error;
  }
  return 0.0;
}

/// A shorter step than one that was good.
void ReferenceIntegrator::step_again(State& state, double seconds) const {
  state.extrapolation.step(
      [&](double, const double* numbers, double* to) { rates(state, numbers, to); }, state.numbers.data(),
      seconds, [&](const double* numbers, const double* difference) { return error(numbers, difference); });
  state.next = state.extrapolation.result();
}

double ReferenceIntegrator::error(const double* numbers, const double* difference) const {
  double most = 0.0;
  const auto compare = [&](std::size_t from, std::size_t count, double least) {
    const double wrong = largest(difference + from, count);
    if (wrong == 0.0) return;
    const double share = wrong / (tolerance_ * std::max(least, largest(numbers + from, count)));
    if (!(share <= most)) most = share;
  };
  compare(0, points(), kLeastPosition);
  compare(points(), points(), kLeastVelocity);
  compare(2 * points(), elements_.coils.size(), kLeastCurrent);
  return most;
}

double ReferenceIntegrator::contact_margin(const State& state, const double* numbers,
                                           std::size_t contact) const {
  const double n = indentation_in(numbers, contact);
  if (state.contacts[contact] == ContactState::Open) return -n;
  const double push = 1.0 + state.loss[contact] * approach_in(numbers, contact);
  return std::min(n, state.contacts[contact] == ContactState::Pressing ? push : -push);
}

double ReferenceIntegrator::least_margin(State& state, const double* numbers) const {
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t c = 0; c < laws_.size(); ++c) least = std::min(least, contact_margin(state, numbers, c));
  for (std::size_t f = 0; f < elements_.frictions.size(); ++f)
    least = std::min(least, friction_margin(state, numbers, f));
  for (std::size_t b = 0; b < elements_.bonds.size(); ++b)
    least = std::min(least, bond_margin(state, numbers, b));
  return least;
}

/// Cuts the step to `next` behind the first event in it.
double ReferenceIntegrator::until_event(State& state, double seconds) const {
  const double at_end = least_margin(state, state.next.data());
  if (!(at_end < 0.0)) return seconds;
  const auto margin_at = [&](double time) {
    if (time <= 0.0) return std::numeric_limits<double>::min();
    if (time == seconds) return at_end;
    step_again(state, time);
    const double least = least_margin(state, state.next.data());
    return least == 0.0 ? std::numeric_limits<double>::min() : least;  // not yet behind it
  };
  const auto event = find_zero(margin_at, 0.0, seconds, kInstant * seconds);
  const double behind = event.f_near < 0.0 ? event.near : event.far;
  step_again(state, behind);
  return behind;
}

/// A contact may close or open and be back within a step: then its motion turns in the step.
bool ReferenceIntegrator::turns(const State& state, double seconds, std::size_t contact) const {
  const double before = approach_in(state.numbers.data(), contact);
  const double after = approach_in(state.next.data(), contact);
  const bool open = state.contacts[contact] == ContactState::Open;
  if (open ? !(before > 0.0 && after < 0.0) : !(before < 0.0 && after > 0.0)) return false;
  const double far = std::abs(indentation_in(state.numbers.data(), contact));
  return far < 2.0 * seconds * std::max(std::abs(before), std::abs(after));
}

/// Cuts the step to `next` where such a motion turns, so that the deepest point is the end of a step.
double ReferenceIntegrator::until_turn(State& state, double seconds) const {
  for (std::size_t c = 0; c < laws_.size(); ++c) {
    if (!turns(state, seconds, c)) continue;
    const double before = approach_in(state.numbers.data(), c);
    const auto approach_at = [&](double time) {
      if (time <= 0.0) return before;
      step_again(state, time);
      const double approach = approach_in(state.next.data(), c);
      return approach == 0.0 ? std::copysign(std::numeric_limits<double>::min(), before) : approach;
    };
    const auto turn = find_zero(approach_at, 0.0, seconds, kInstant * seconds);
    seconds = (turn.f_near < 0.0) == (before < 0.0) ? turn.far : turn.near;
    step_again(state, seconds);
  }
  return seconds;
}

void ReferenceIntegrator::switch_contact(State& state, std::size_t contact) const {
  const double* numbers = state.numbers.data();
  auto& contact_state = state.contacts[contact];
  if (contact_state == ContactState::Open)
    state.loss[contact] = start_loss(contact, approach_in(numbers, contact));
  if (indentation_in(numbers, contact) < 0.0)
    contact_state = ContactState::Open;
  else
    contact_state =
        contact_state == ContactState::Pressing ? ContactState::Releasing : ContactState::Pressing;
}

void ReferenceIntegrator::switch_over(State& state) const {
  const double* numbers = state.numbers.data();
  for (std::size_t c = 0; c < laws_.size(); ++c)
    if (contact_margin(state, numbers, c) < 0.0) switch_contact(state, c);
  for (std::size_t b = 0; b < elements_.bonds.size(); ++b) {
    if (!(bond_margin(state, numbers, b) < 0.0)) continue;
    auto& slide = state.slide[elements_.frictions.size() + b];
    const double n = between(numbers, elements_.bonds[b].lower, elements_.bonds[b].upper);
    slide = slide != 0.0 ? 0.0 : n > 0.0 ? 1.0 : -1.0;
  }
  for (std::size_t f = 0; f < elements_.frictions.size(); ++f)
    if (friction_margin(state, numbers, f) < 0.0) switch_friction(state, f);
}

}  // namespace tactus
