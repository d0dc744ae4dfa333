#include <algorithm>

#include "engine/physics/network.h"

namespace tactus {
namespace {

std::size_t index(int i) { return static_cast<std::size_t>(i); }

double velocity_at(const NetworkState& state, int slot, double k) {
  return (1.5 * state.moved[index(slot)] - 0.5 * state.moved_before[index(slot)]) / k;
}

double extension_at(const NetworkState& state, const Spring& spring) {
  return state.position[index(spring.upper)] - state.position[index(spring.lower)] - spring.rest;
}

}  // namespace

double Network::indentation_now(const NetworkState& state, const ContactModel& contact) const noexcept {
  return state.position[index(contact.lower)] - state.position[index(contact.upper)] + contact.offset;
}

double Network::position(const NetworkState& state, int point) const noexcept {
  return state.position[index(slot_[index(point)])];
}

double Network::velocity(const NetworkState& state, int point) const noexcept {
  return velocity_at(state, slot_[index(point)], k_);
}

double Network::extension(const NetworkState& state, int spring) const noexcept {
  return extension_at(state, springs_[index(spring)]);
}

double Network::spring_force(const NetworkState& state, int spring) const noexcept {
  const auto& s = springs_[index(spring)];
  return s.stiffness * extension_at(state, s) +
         s.damping * (velocity_at(state, s.upper, k_) - velocity_at(state, s.lower, k_));
}

double Network::indentation(const NetworkState& state, int contact) const noexcept {
  return std::max(0.0, indentation_now(state, contacts_[index(contact)]));
}

double Network::contact_force(const NetworkState& state, int contact) const noexcept {
  const auto& c = contacts_[index(contact)];
  const double n = indentation_now(state, c);
  if (n <= 0.0) return 0.0;
  const double speed = velocity_at(state, c.lower, k_) - velocity_at(state, c.upper, k_);
  return std::max(0.0, c.law.force(n) * (1.0 + state.loss[index(contact)] * speed));
}

double Network::applied_force(const NetworkState& state, int force) const noexcept {
  const auto& f = forces_[index(force)];
  if (f.low_pass >= 0) return state.low_pass[index(f.low_pass)].value;
  return f.drive.signal < 0 ? 0.0 : state.held[index(f.drive.signal)];
}

/// From half a step ago to now: exact for the voltage that was held last, at a constant speed.
double Network::current(const NetworkState& state, int coil) const noexcept {
  const auto& c = coils_[index(coil)];
  const double voltage = c.voltage.signal < 0 ? 0.0 : state.held[index(c.voltage.signal)];
  const double speed = velocity_at(state, c.on, k_) - velocity_at(state, c.against, k_);
  const double final_current = (voltage - c.force_factor * speed) / c.resistance;
  return final_current + (state.current[index(coil)] - final_current) * c.half_step_decay;
}

double Network::coil_force(const NetworkState& state, int coil) const noexcept {
  return coils_[index(coil)].force_factor * current(state, coil);
}

}  // namespace tactus
