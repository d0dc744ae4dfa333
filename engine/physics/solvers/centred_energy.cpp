#include "engine/physics/index.h"
#include "engine/physics/solvers/centred_scheme.h"

namespace tactus {
namespace {

/// The energy of a spring between two instants, in the form that each way of stepping it conserves.
double spring_energy(double stiffness, double extension, double before, bool averaged) {
  return 0.5 * stiffness * (averaged ? square(0.5 * (extension + before)) : extension * before);
}

double contact_energy(const ContactLaw& law, double n) { return n > 0.0 ? law.energy(n) : 0.0; }

}  // namespace

double CentredScheme::energy(const NetworkState& state) const noexcept {
  double sum = 0.0;
  for (std::size_t i = 0; i < model_.mass.size(); ++i)
    sum += 0.5 * model_.mass[i] * square(state.moved[i] / model_.k);
  for (const auto& s : model_.springs) {
    const auto lower = index(s.lower), upper = index(s.upper);
    const double extension = state.position[upper] - state.position[lower] - s.rest;
    const double before = extension - (state.moved[upper] - state.moved[lower]);
    sum += spring_energy(s.stiffness, extension, before, averaged_);
  }
  for (std::size_t c = 0; c < model_.contacts.size(); ++c) {
    const auto& contact = model_.contacts[c];
    const auto lower = index(contact.lower), upper = index(contact.upper);
    const double n = state.position[lower] - state.position[upper] + contact.offset;
    const double before = n - (state.moved[lower] - state.moved[upper]);
    if (kind_ == Kind::Passive)
      sum += 0.5 * square(state.root[c]);
    else if (kind_ == Kind::Implicit)
      sum += 0.5 * (contact_energy(contact.law, n) + contact_energy(contact.law, before));
    else
      sum += contact_energy(contact.law, n);
  }
  for (std::size_t p = model_.contacts.size(); p < state.root.size(); ++p) sum += 0.5 * square(state.root[p]);
  for (std::size_t i = 0; i < model_.coils.size(); ++i)
    sum += 0.5 * model_.coils[i].inductance * square(state.current[i]);
  return sum;
}

/// With d = q+ - q- of a point, a force F does the work F d/2 in a step. Called before `moved` is advanced.
void CentredScheme::audit(NetworkState& state) const noexcept {
  const auto way = [&](int slot) { return state.moved[index(slot)] + 0.5 * state.change[index(slot)]; };
  const auto by_hand = [&](int slot) { return model_.is_mass(slot) ? 0.0 : way(slot); };
  for (std::size_t i = 0; i < model_.forces.size(); ++i)
    state.supplied += state.force[i] * way(model_.forces[i].slot);
  for (std::size_t i = 0; i < model_.ports.size(); ++i) {
    const double moved = way(model_.ports[i].wave.slot);
    state.supplied += 2.0 * state.wave[i] * moved;
    state.dissipated += model_.ports[i].impedance * square(moved) / model_.k;
  }
  for (const auto& s : model_.springs) {
    const auto lower = index(s.lower), upper = index(s.upper);
    const double speed = (way(s.upper) - way(s.lower)) / model_.k;
    double extension = state.position[upper] - state.position[lower] - s.rest;
    if (averaged_) extension += 0.25 * (state.change[upper] - state.change[lower]);
    const double tension = s.stiffness * extension + s.damping * speed;
    state.supplied += tension * (by_hand(s.upper) - by_hand(s.lower));
    state.dissipated += s.damping * speed * speed * model_.k;
  }
  couplings_.push_all(state, [&](int slot, double force) { state.supplied -= force * by_hand(slot); });
  for (const auto& touch : state.touching) state.dissipated += lost(state, touch);
  for (std::size_t f = 0; f < couplings_.frictions(); ++f)
    state.dissipated += 0.5 * state.rub[f] * couplings_.motion(state, couplings_.first_friction() + f);
  for (std::size_t i = 0; i < model_.coils.size(); ++i) {
    const auto& coil = model_.coils[i];
    const double force = coil.force_factor * state.mean_current[i];
    state.supplied += model_.k * state.voltage[i] * state.mean_current[i];
    state.supplied += force * (by_hand(coil.against) - by_hand(coil.on));
    state.dissipated += model_.k * coil.resistance * square(state.mean_current[i]);
  }
}

/// What a touch takes beyond what it stores.
double CentredScheme::lost(const NetworkState& state, const Touch& touch) const noexcept {
  const auto c = index(touch.coupling);
  if (kind_ != Kind::Implicit || c >= model_.contacts.size())
    return 0.5 * (touch.resistance - 0.25 * square(touch.slope)) * square(touch.motion);
  const auto& contact = model_.contacts[c];
  const auto lower = index(contact.lower), upper = index(contact.upper);
  const double n = state.position[lower] - state.position[upper] + contact.offset;
  const double before = n - (state.moved[lower] - state.moved[upper]);
  const double stored =
      contact_energy(contact.law, before + touch.motion) - contact_energy(contact.law, before);
  return 0.5 * (touch.force * touch.motion - stored);
}

}  // namespace tactus
