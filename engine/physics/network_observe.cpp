#include <algorithm>
#include <cmath>

#include "engine/physics/index.h"
#include "engine/physics/network.h"

namespace tactus {
namespace {

double extension_of(const NetworkState& state, const Spring& spring) {
  return state.position[index(spring.upper)] - state.position[index(spring.lower)] - spring.rest;
}

double indentation_of(const NetworkState& state, const NetworkModel::Contact& contact) {
  return state.position[index(contact.lower)] - state.position[index(contact.upper)] + contact.offset;
}

}  // namespace

double Network::speed_between(const NetworkState& state, int one, int other) const noexcept {
  return scheme_->velocity(state, one) - scheme_->velocity(state, other);
}

double Network::tension(const NetworkState& state, const Spring& s) const noexcept {
  return s.stiffness * extension_of(state, s) + s.damping * speed_between(state, s.upper, s.lower);
}

double Network::push_of(const NetworkState& state, int contact) const noexcept {
  const auto& c = model_->contacts[index(contact)];
  const double n = indentation_of(state, c);
  if (n <= 0.0) return 0.0;
  const double speed = speed_between(state, c.lower, c.upper);
  return std::max(0.0, c.law.force(n) * (1.0 + state.loss[index(contact)] * speed));
}

double Network::position(const NetworkState& state, int point) const noexcept {
  return state.position[index(model_->slot[index(point)])];
}

double Network::velocity(const NetworkState& state, int point) const noexcept {
  return scheme_->velocity(state, model_->slot[index(point)]);
}

double Network::extension(const NetworkState& state, int spring) const noexcept {
  return extension_of(state, model_->springs[index(spring)]);
}

double Network::spring_force(const NetworkState& state, int spring) const noexcept {
  return tension(state, model_->springs[index(spring)]);
}

double Network::indentation(const NetworkState& state, int contact) const noexcept {
  return std::max(0.0, indentation_of(state, model_->contacts[index(contact)]));
}

double Network::contact_force(const NetworkState& state, int contact) const noexcept {
  return push_of(state, contact);
}

double Network::applied_force(const NetworkState& state, int force) const noexcept {
  const auto& f = model_->forces[index(force)];
  if (f.low_pass >= 0) return state.low_pass[index(f.low_pass)].value;
  return f.input.signal < 0 ? 0.0 : state.held[index(f.input.signal)];
}

double Network::current(const NetworkState& state, int coil) const noexcept {
  return scheme_->current(state, coil);
}

double Network::coil_force(const NetworkState& state, int coil) const noexcept {
  return model_->coils[index(coil)].force_factor * current(state, coil);
}

double Network::friction_force(const NetworkState& state, int friction) const noexcept {
  return state.rub[index(friction)];
}

double Network::friction_velocity(const NetworkState& state, int friction) const noexcept {
  return state.slide[index(friction)];
}

double Network::bond_force(const NetworkState& state, int bond) const noexcept {
  if (state.slipped[index(bond)] != 0.0) return 0.0;
  const auto& b = model_->bonds[index(bond)];
  const double n = state.position[index(b.lower)] - state.position[index(b.upper)];
  const double law = b.law->linear()
                         ? b.law->root_slope(n) * state.root[model_->contacts.size() + index(bond)]
                         : b.law->force(n);
  return law + b.damping * speed_between(state, b.lower, b.upper);
}

double Network::bond_distance(const NetworkState& state, int bond) const noexcept {
  const auto& b = model_->bonds[index(bond)];
  return state.position[index(b.lower)] - state.position[index(b.upper)];
}

double Network::wave(const NetworkState& state, int port) const noexcept {
  return state.wave_back[index(port)];
}

double Network::port_force(const NetworkState& state, int port) const noexcept {
  return state.wave[index(port)] + state.wave_back[index(port)];
}

double Network::energy(const NetworkState& state) const noexcept { return scheme_->energy(state); }

}  // namespace tactus
