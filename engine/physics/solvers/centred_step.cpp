#include <algorithm>
#include <cmath>

#include "engine/physics/index.h"
#include "engine/physics/solvers/centred_scheme.h"
#include "engine/physics/solvers/wide.h"

namespace tactus {
/// Positions before the start, from position, velocity and acceleration at the start: consistent to second
/// order. Inputs count as 0 before the start, which makes the first step exact for any first input. Schemes
/// that solve for A bend these forces by A^-1 in place of k^2/m, which is the trapezoidal rule's own step
/// back: what is too stiff for the rate swings as far as it was drawn, and no farther.
void CentredScheme::start(NetworkState& state) const noexcept {
  for (std::size_t i = 0; i < start_velocity_.size(); ++i) state.moved[i] = model_.k * start_velocity_[i];
  state.touching.clear();
  for (std::size_t c = 0; c < model_.contacts.size(); ++c) {
    const auto& contact = model_.contacts[c];
    const auto lower = index(contact.lower), upper = index(contact.upper);
    const double motion = state.moved[lower] - state.moved[upper];
    const double n = state.position[lower] - state.position[upper] + contact.offset;
    state.loss[c] = contact.loss;
    if (n <= 0.0) continue;
    watch_touch(model_, state, c, n, std::max(n, motion));
    const double rate = 1.0 + state.loss[c] * motion / model_.k;
    state.touching.push_back(
        {.coupling = static_cast<int>(c),
         .force = softened(c, contact.law.stiffness(n), std::max(0.0, contact.law.force(n) * rate))});
  }
  slow(state);
  links_.apply(state.position.data(), state.moved_before.data(), state.change.data());
  for (const auto& force : model_.forces)
    if (force.low_pass >= 0 && model_.is_mass(force.slot))
      state.change[index(force.slot)] += state.low_pass[index(force.low_pass)].value;
  for (std::size_t b = 0; b < model_.bonds.size(); ++b) {
    const auto& bond = model_.bonds[b];
    const auto lower = index(bond.lower), upper = index(bond.upper), c = model_.contacts.size() + b;
    const double n = state.position[lower] - state.position[upper];
    const double speed = (state.moved[lower] - state.moved[upper]) / model_.k;
    if (state.slipped[b] == 0.0)
      state.touching.push_back({.coupling = static_cast<int>(c),
                                .force = softened(c, std::max(0.0, bond.law->stiffness(n)),
                                                  bond.law->force(n) + bond.damping * speed)});
  }
  push(state);
  bend(state);
  for (std::size_t i = 0; i < model_.mass.size(); ++i) {
    const double straight = state.moved[i];
    state.moved[i] = straight - 0.5 * state.change[i];
    state.moved_before[i] = straight - 1.5 * state.change[i];
  }
  state.touching.clear();
  store_energy(state);
}

/// What dampers see at the start, into `moved_before`: A^-1 (M/k^2) of the motion, so that those that stop a
/// mass within a step give it nothing.
void CentredScheme::slow(NetworkState& state) const noexcept {
  std::copy(state.moved.begin(), state.moved.end(), state.moved_before.begin());
  if (!factored()) return;
  const auto masses = model_.mass.size();
  for (std::size_t i = 0; i < masses; ++i) state.moved_before[i] /= model_.scale[i];
  solver_.solve({state.moved_before.data(), masses}, state.work);
}

void CentredScheme::bend(NetworkState& state) const noexcept {
  const auto masses = model_.mass.size();
  if (!factored()) return multiply(model_.scale.data(), masses, state.change.data());
  solver_.solve({state.change.data(), masses}, state.work);
}

/// What is left of a force whose own stiffness the step averages, as A averages that of the springs.
double CentredScheme::softened(std::size_t coupling, double stiffness, double force) const noexcept {
  return factored() ? force / (1.0 + 0.25 * couplings_.mutual(coupling, coupling) * stiffness) : force;
}

void CentredScheme::store_energy(NetworkState& state) const noexcept { couplings_.store_energy(state); }

void CentredScheme::step(NetworkState& state) const noexcept {
  start_forces(state);
  if (!model_.motions.empty()) move_driven(state);
  add_applied(state);
  if (!model_.coils.empty()) add_coils(state);
  if (factored()) solver_.solve({state.change.data(), model_.mass.size()}, state.work);
  if (!couplings_.empty()) {
    couplings_.solve(state);
    if (factored())
      couplings_.move(state);
    else
      push(state);
    couplings_.finish(state);
  }
  if (!model_.coils.empty()) step_currents(state);
  if (!model_.ports.empty()) send_waves(state);
  if (state.audit) audit(state);
  advance(state);
}

/// The forces of all links; of a row, those that its pass does not know.
void CentredScheme::start_forces(NetworkState& state) const noexcept {
  if (in_row_ && jumps_.entries().empty())
    row_.fill(constant_.data(), state.change.data());
  else
    (in_row_ ? jumps_ : links_).apply(state.position.data(), state.moved.data(), state.change.data());
}

void CentredScheme::move_driven(NetworkState& state) const noexcept {
  for (std::size_t i = 0; i < model_.motions.size(); ++i) {
    const auto slot = index(model_.motions[i].slot);
    state.change[slot] = state.next[i] - state.position[slot] - state.moved[slot];
  }
  for (const auto& c : driven_columns_) state.change[index(c.mass)] -= c.a * state.change[index(c.driven)];
}

void CentredScheme::add_applied(NetworkState& state) const noexcept {
  for (std::size_t i = 0; i < model_.forces.size(); ++i) {
    const int slot = model_.forces[i].slot;
    if (model_.is_mass(slot)) state.change[index(slot)] += state.force[i];
  }
  for (std::size_t i = 0; i < model_.ports.size(); ++i) {
    const int slot = model_.ports[i].wave.slot;
    if (model_.is_mass(slot)) state.change[index(slot)] += 2.0 * state.wave[i];
  }
}

/// The part of a coil's force that is there without motion; what motion adds is in the link operator.
void CentredScheme::add_coils(NetworkState& state) const noexcept {
  for (std::size_t i = 0; i < model_.coils.size(); ++i) {
    const auto& coil = model_.coils[i];
    state.mean_current[i] = (state.voltage[i] + coil.memory * state.current[i]) / coil.impedance;
    const double force = coil.force_factor * state.mean_current[i];
    if (model_.is_mass(coil.on)) state.change[index(coil.on)] += force;
    if (model_.is_mass(coil.against)) state.change[index(coil.against)] -= force;
  }
}

/// The couplings' forces on top of the others, where A is not solved for any more.
void CentredScheme::push(NetworkState& state) const noexcept {
  couplings_.push_all(state, [&](int slot, double force) {
    if (model_.is_mass(slot)) state.change[index(slot)] += force;
  });
}

double CentredScheme::travel(const NetworkState& state, int slot) const noexcept {
  const double centre = factored() ? 0.5 : 0.0;
  return state.moved[index(slot)] + centre * state.change[index(slot)];
}

void CentredScheme::step_currents(NetworkState& state) const noexcept {
  for (std::size_t i = 0; i < model_.coils.size(); ++i) {
    const auto& coil = model_.coils[i];
    const double motion = travel(state, coil.on) - travel(state, coil.against);
    state.mean_current[i] -= coil.force_factor * motion / (model_.k * coil.impedance);
    state.current[i] = 2.0 * state.mean_current[i] - state.current[i];
  }
}

void CentredScheme::send_waves(NetworkState& state) const noexcept {
  for (std::size_t i = 0; i < model_.ports.size(); ++i) {
    const auto& port = model_.ports[i];
    state.wave_back[i] += state.wave[i] - port.impedance * travel(state, port.wave.slot) / model_.k;
  }
}

/// u+ = u + e, q+ = q + u+, where the explicit solver's e is still k^2/m away.
void CentredScheme::advance(NetworkState& state) const noexcept {
  const auto masses = model_.mass.size();
  double *q = state.position.data(), *u = state.moved.data(), *e = state.change.data();
  double* u_next = state.moved_before.data();
  if (in_row_)
    row_.step(q, u, u_next, e);
  else if (!factored())
    multiply(model_.scale.data(), masses, e);
  const auto first = in_row_ ? masses : 0;
  const auto go = [=]<class Wide>(std::size_t i) {
    const Wide moving = load<Wide>(u + first + i) + load<Wide>(e + first + i);
    store(moving, u_next + first + i);
    store(load<Wide>(q + first + i) + moving, q + first + i);
  };
  for_all(masses + model_.motions.size() - first, go);
  state.moved.swap(state.moved_before);
}

}  // namespace tactus
