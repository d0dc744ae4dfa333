#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "engine/physics/network.h"

namespace tactus {
namespace {

std::size_t index(int i) { return static_cast<std::size_t>(i); }

// Vector instructions whatever the compiler's mood; sums and products of single numbers, so the same bits.
auto array(Numbers& numbers, std::size_t from, std::size_t count) {
  return Eigen::Map<Eigen::ArrayXd>(numbers.data() + from, static_cast<Eigen::Index>(count));
}
template <class List>
auto array(const List& numbers, std::size_t from, std::size_t count) {
  return Eigen::Map<const Eigen::ArrayXd>(numbers.data() + from, static_cast<Eigen::Index>(count));
}

/// What enters at frame n; nothing is connected to signal -1.
double now(const Drive& drive, const double* inputs) { return drive.signal < 0 ? 0.0 : inputs[drive.signal]; }
double before(const NetworkState& state, const Drive& drive) {
  return drive.signal < 0 ? 0.0 : state.held[index(drive.signal)];
}

/// A value held from frame to frame, as a centred scheme sees it at the instant of step `part` of a frame.
double centred(const NetworkState& state, const Drive& drive, const double* inputs, int part) {
  const double value = now(drive, inputs);
  return part == 0 ? 0.5 * (before(state, drive) + value) : value;
}

}  // namespace

void Network::reset(NetworkState& state) const noexcept {
  std::copy(start_position_.begin(), start_position_.end(), state.position.begin());
  for (auto* list : {&state.moved_before, &state.change, &state.current, &state.mean_current, &state.voltage,
                     &state.force, &state.held})
    std::fill(list->begin(), list->end(), 0.0);
  std::fill(state.low_pass.begin(), state.low_pass.end(), CriticalLowPass::State{});
  state.touching.clear();
  state.settled = false;
  state.supplied = state.dissipated = 0.0;
  start_moving(state);
}

void Network::adopt(NetworkState& state, const NetworkState& before) const noexcept {
  using Member = Numbers NetworkState::*;
  for (const Member list :
       {&NetworkState::position, &NetworkState::moved, &NetworkState::moved_before, &NetworkState::current,
        &NetworkState::mean_current, &NetworkState::voltage, &NetworkState::force, &NetworkState::held})
    std::copy((before.*list).begin(), (before.*list).end(), (state.*list).begin());
  std::copy(before.low_pass.begin(), before.low_pass.end(), state.low_pass.begin());
  state.settled = before.settled;
  store_energy(state);
}

/// Positions before the start, from position, velocity and acceleration at the start: consistent to second
/// order. Inputs count as 0 before the start, which with `centred` makes the first step exact for any first
/// input.
void Network::start_moving(NetworkState& state) const noexcept {
  for (std::size_t i = 0; i < start_velocity_.size(); ++i) state.moved[i] = k_ * start_velocity_[i];
  for (std::size_t c = 0; c < contacts_.size(); ++c) {
    const double motion = state.moved[index(contacts_[c].lower)] - state.moved[index(contacts_[c].upper)];
    state.loss[c] = contacts_[c].loss;
    const double n = indentation_now(state, contacts_[c]);
    if (n > 0.0) watch_touch(state, c, n, std::max(n, motion));
  }
  links_.apply(state.position.data(), state.moved.data(), state.change.data());
  for (const auto& force : forces_)
    if (force.low_pass >= 0) state.change[index(force.slot)] += state.low_pass[index(force.low_pass)].value;
  push_contacts(state);
  for (std::size_t i = 0; i < mass_.size(); ++i) {
    const double bend = scale_[i] * state.change[i], straight = state.moved[i];
    state.moved[i] = straight - 0.5 * bend;
    state.moved_before[i] = straight - 1.5 * bend;
  }
  store_energy(state);
}

/// What each contact holds half a step ago.
void Network::store_energy(NetworkState& state) const noexcept {
  for (std::size_t c = 0; c < contacts_.size(); ++c) {
    const double motion = state.moved[index(contacts_[c].lower)] - state.moved[index(contacts_[c].upper)];
    const double n = indentation_now(state, contacts_[c]) - 0.5 * motion;
    state.root[c] = n > 0.0 ? contacts_[c].law.root(n) : 0.0;
  }
}

/// Driven points and hands do not jump to their first place, they have been there before the start.
void Network::settle(NetworkState& state, const double* inputs) const noexcept {
  for (const auto& motion : motions_) {
    const double place = now(motion.drive, inputs);
    state.position[index(motion.slot)] = place;
    state.moved[index(motion.slot)] = state.moved_before[index(motion.slot)] = 0.0;
    if (motion.drive.signal >= 0) state.held[index(motion.drive.signal)] = place;
    if (motion.low_pass >= 0) state.low_pass[index(motion.low_pass)] = {place, 0.0};
  }
  for (const auto& force : forces_)
    if (force.low_pass >= 0) state.low_pass[index(force.low_pass)] = {now(force.drive, inputs), 0.0};
  state.settled = true;
  start_moving(state);
}

void Network::step(NetworkState& state, const double* inputs) const noexcept {
  if (!state.settled) settle(state, inputs);
  for (int part = 0; part < oversample_; ++part) substep(state, inputs, part);
  std::copy_n(inputs, signals_, state.held.begin());
}

void Network::substep(NetworkState& state, const double* inputs, int part) const noexcept {
  start_forces(state);
  move_driven(state, inputs, part);
  add_forces(state, inputs, part);
  add_coils(state, inputs, part);
  if (solver_ == Solver::Explicit) {
    push_contacts(state);
  } else {
    solve_masses(state);
    find_touching(state);
    if (!state.touching.empty()) solve_touching(state);
  }
  step_currents(state);
  if (state.audit) audit(state);
  advance(state);
}

/// The forces of all links; of a row, those that its pass does not know.
void Network::start_forces(NetworkState& state) const noexcept {
  if (in_row_ && jumps_.entries().empty())
    row_.fill(constant_.data(), state.change.data());
  else
    (in_row_ ? jumps_ : links_).apply(state.position.data(), state.moved.data(), state.change.data());
}

/// u+ = u + e, q+ = q + u+, where the explicit solver's e is still k^2/m away.
void Network::advance(NetworkState& state) const noexcept {
  const auto masses = mass_.size(), moving = masses + motions_.size();
  const auto scaled = solver_ == Solver::Explicit ? masses : 0;
  if (in_row_) {
    row_.step(state.position.data(), state.moved.data(), state.moved_before.data(), state.change.data());
  } else {
    array(state.moved_before, 0, scaled) =
        array(state.moved, 0, scaled) + array(scale_, 0, scaled) * array(state.change, 0, scaled);
    array(state.position, 0, scaled) += array(state.moved_before, 0, scaled);
  }
  const auto rest = moving - scaled;
  array(state.moved_before, scaled, rest) =
      array(state.moved, scaled, rest) + array(state.change, scaled, rest);
  array(state.position, scaled, rest) += array(state.moved_before, scaled, rest);
  state.moved.swap(state.moved_before);
}

void Network::move_driven(NetworkState& state, const double* inputs, int part) const noexcept {
  for (const auto& motion : motions_) {
    double next = now(motion.drive, inputs);
    if (motion.low_pass >= 0) {
      auto& filter = state.low_pass[index(motion.low_pass)];
      low_passes_[index(motion.low_pass)].step(filter, next);
      next = filter.value;
    } else if (part + 1 < oversample_) {
      const double last = before(state, motion.drive);
      next = last + (next - last) * (part + 1) / oversample_;
    }
    const auto slot = index(motion.slot);
    state.change[slot] = next - state.position[slot] - state.moved[slot];
  }
  for (const auto& c : couplings_) state.change[index(c.mass)] -= c.a * state.change[index(c.driven)];
}

void Network::add_forces(NetworkState& state, const double* inputs, int part) const noexcept {
  for (std::size_t i = 0; i < forces_.size(); ++i) {
    const auto& force = forces_[i];
    if (force.low_pass >= 0) {
      auto& filter = state.low_pass[index(force.low_pass)];
      state.force[i] = filter.value;
      low_passes_[index(force.low_pass)].step(filter, now(force.drive, inputs));
    } else {
      state.force[i] = centred(state, force.drive, inputs, part);
    }
    if (is_mass(force.slot)) state.change[index(force.slot)] += state.force[i];
  }
}

/// The part of a coil's force that is there without motion; what motion adds is in the link operator.
void Network::add_coils(NetworkState& state, const double* inputs, int part) const noexcept {
  for (std::size_t i = 0; i < coils_.size(); ++i) {
    const auto& coil = coils_[i];
    state.voltage[i] = centred(state, coil.voltage, inputs, part);
    state.mean_current[i] = (state.voltage[i] + coil.memory * state.current[i]) / coil.impedance;
    const double force = coil.force_factor * state.mean_current[i];
    if (is_mass(coil.on)) state.change[index(coil.on)] += force;
    if (is_mass(coil.against)) state.change[index(coil.against)] -= force;
  }
}

void Network::step_currents(NetworkState& state) const noexcept {
  const double centre = solver_ == Solver::Passive ? 0.5 : 0.0;
  for (std::size_t i = 0; i < coils_.size(); ++i) {
    const auto& coil = coils_[i];
    const auto on = index(coil.on), against = index(coil.against);
    const double motion = (state.moved[on] + centre * state.change[on]) -
                          (state.moved[against] + centre * state.change[against]);
    state.mean_current[i] -= coil.force_factor * motion / (k_ * coil.impedance);
    state.current[i] = 2.0 * state.mean_current[i] - state.current[i];
  }
}

void Network::push(NetworkState& state, const ContactModel& contact, double force) const noexcept {
  if (is_mass(contact.lower)) state.change[index(contact.lower)] -= force;
  if (is_mass(contact.upper)) state.change[index(contact.upper)] += force;
}

void Network::watch_touch(NetworkState& state, std::size_t contact, double n, double motion) const noexcept {
  // Slower touches would ask for an endless loss; at 0.1 mm/s nothing is heard or felt any more.
  constexpr double kSlowest = 1e-4;
  if (contacts_[contact].loss_speed > 0.0 && n <= motion)
    state.loss[contact] = contacts_[contact].loss_speed / std::max(motion / k_, kSlowest);
}

void Network::push_contacts(NetworkState& state) const noexcept {
  for (std::size_t c = 0; c < contacts_.size(); ++c) {
    const auto& contact = contacts_[c];
    const double n = indentation_now(state, contact);
    if (n <= 0.0) continue;
    const double motion = state.moved[index(contact.lower)] - state.moved[index(contact.upper)];
    watch_touch(state, c, n, motion);
    push(state, contact, std::max(0.0, contact.law.force(n) * (1.0 + state.loss[c] * motion / k_)));
  }
}

}  // namespace tactus
