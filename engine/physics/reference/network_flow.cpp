#include "engine/physics/reference/network_flow.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "engine/physics/index.h"

namespace tactus {
NetworkFlow::NetworkFlow(NetworkElements elements, Seconds frame, double tolerance)
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

NetworkFlow::State NetworkFlow::initial(std::span<const double> motions) const {
  State state;
  state.numbers.resize(2 * points() + elements_.coils.size());
  state.next = state.slope = state.numbers;
  state.loss.resize(laws_.size());
  state.touch.resize(laws_.size());
  state.slide.resize(elements_.frictions.size() + elements_.bonds.size());
  state.hold.resize(elements_.frictions.size());
  state.mutual.resize(elements_.frictions.size() * elements_.frictions.size());
  state.inputs.resize(held());
  if (!exact()) state.extrapolation = Extrapolation(state.numbers.size());
  reset(state, motions);
  return state;
}

void NetworkFlow::reset(State& state, std::span<const double> motions) const {
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
  find_touches(state);
  std::fill(state.slide.begin(), state.slide.end(), Slide::Holds);
  std::fill(state.hold.begin(), state.hold.end(), 0.0);
  state.step_s = 0.0;
}

void NetworkFlow::find_touches(State& state) const {
  const double* numbers = state.numbers.data();
  for (std::size_t c = 0; c < laws_.size(); ++c) {
    const bool pulls = 1.0 + state.loss[c] * approach_in(numbers, c) < 0.0;
    state.touch[c] = !(indentation_in(numbers, c) > 0.0) ? Touch::Open
                     : pulls                             ? Touch::LettingGo
                                                         : Touch::Pressing;
  }
}

void NetworkFlow::advance(State& state, const Inputs& inputs) const {
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

double NetworkFlow::indentation_in(const double* numbers, std::size_t contact) const {
  const auto& c = elements_.contacts[contact];
  return numbers[c.lower] - numbers[c.upper] + c.offset;
}

double NetworkFlow::approach_in(const double* numbers, std::size_t contact) const {
  const auto& c = elements_.contacts[contact];
  const double* velocities = numbers + points();
  return velocities[c.lower] - velocities[c.upper];
}

double NetworkFlow::start_loss(std::size_t contact, double speed) const {
  constexpr double kSlowest_m_per_s = 1e-4;
  if (loss_speed_[contact] == 0.0) return elements_.contacts[contact].loss;
  return loss_speed_[contact] / std::max(speed, kSlowest_m_per_s);
}

/// Without an inductance the current follows the voltage at once.
double NetworkFlow::current_in(const double* numbers, const double* voltages, std::size_t coil) const {
  const auto& c = elements_.coils[coil];
  if (c.inductance > 0.0) return numbers[2 * points() + coil];
  const double* velocities = numbers + points();
  return (voltages[coil] - c.force_factor * (velocities[c.on] - velocities[c.against])) / c.resistance;
}

void NetworkFlow::rates(State& state, const double* numbers, double* slope) const {
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

void NetworkFlow::add_springs(const double* numbers, double* force) const {
  const double* velocities = numbers + points();
  for (const auto& s : elements_.springs) {
    const double tension = s.stiffness * (numbers[s.upper] - numbers[s.lower] - s.rest) +
                           s.damping * (velocities[s.upper] - velocities[s.lower]);
    force[s.lower] += tension;
    force[s.upper] -= tension;
  }
}

void NetworkFlow::add_contacts(const State& state, const double* numbers, double* force) const {
  for (std::size_t c = 0; c < laws_.size(); ++c) {
    const double push = push_in(state, numbers, c);
    force[elements_.contacts[c].lower] -= push;
    force[elements_.contacts[c].upper] += push;
  }
}

/// What is held over a frame: forces, and waves with the impedance of their ports.
void NetworkFlow::add_held(const State& state, const double* numbers, double* force) const {
  for (std::size_t i = 0; i < elements_.forces.size(); ++i) force[elements_.forces[i].on] += state.inputs[i];
  const double* waves = state.inputs.data() + elements_.forces.size() + elements_.coils.size();
  for (std::size_t i = 0; i < elements_.ports.size(); ++i) {
    const auto& port = elements_.ports[i];
    force[port.on] += 2.0 * waves[i] - port.impedance * numbers[points() + index(port.on)];
  }
}

void NetworkFlow::add_coils(const State& state, const double* numbers, double* slope) const {
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

double NetworkFlow::position(const State& state, int point) const { return state.numbers[index(point)]; }

double NetworkFlow::velocity(const State& state, int point) const {
  return state.numbers[points() + index(point)];
}

double NetworkFlow::extension(const State& state, int spring) const {
  const auto& s = elements_.springs[index(spring)];
  return position(state, s.upper) - position(state, s.lower) - s.rest;
}

double NetworkFlow::spring_force(const State& state, int spring) const {
  const auto& s = elements_.springs[index(spring)];
  return s.stiffness * extension(state, spring) +
         s.damping * (velocity(state, s.upper) - velocity(state, s.lower));
}

double NetworkFlow::indentation(const State& state, int contact) const {
  return std::max(0.0, indentation_in(state.numbers.data(), index(contact)));
}

double NetworkFlow::contact_force(const State& state, int contact) const {
  return std::max(0.0, push_in(state, state.numbers.data(), index(contact)));
}

double NetworkFlow::wave(const State& state, int port) const {
  const auto first = elements_.forces.size() + elements_.coils.size();
  const auto& p = elements_.ports[index(port)];
  return state.inputs[first + index(port)] - p.impedance * velocity(state, p.on);
}

double NetworkFlow::port_force(const State& state, int port) const {
  const auto first = elements_.forces.size() + elements_.coils.size();
  return state.inputs[first + index(port)] + wave(state, port);
}

double NetworkFlow::current(const State& state, int coil) const {
  return current_in(state.numbers.data(), state.inputs.data() + elements_.forces.size(), index(coil));
}

double NetworkFlow::coil_force(const State& state, int coil) const {
  return elements_.coils[index(coil)].force_factor * current(state, coil);
}

double NetworkFlow::energy(const State& state) const {
  double sum = 0.0;
  for (std::size_t i = 0; i < points(); ++i)
    if (inverse_mass_[i] > 0.0) sum += 0.5 * elements_.points[i].mass * square(state.numbers[points() + i]);
  for (std::size_t s = 0; s < elements_.springs.size(); ++s)
    sum += 0.5 * elements_.springs[s].stiffness * square(extension(state, static_cast<int>(s)));
  for (std::size_t c = 0; c < laws_.size(); ++c)
    if (const double n = indentation_in(state.numbers.data(), c); n > 0.0) sum += laws_[c].energy(n);
  for (std::size_t p = 0; p < elements_.bonds.size(); ++p)
    if (state.slide[elements_.frictions.size() + p] == Slide::Holds)
      sum += elements_.bonds[p].law->energy(
          between(state.numbers.data(), elements_.bonds[p].lower, elements_.bonds[p].upper));
  for (std::size_t i = 0; i < elements_.coils.size(); ++i)
    sum += 0.5 * elements_.coils[i].inductance * square(current(state, static_cast<int>(i)));
  return sum;
}

}  // namespace tactus
