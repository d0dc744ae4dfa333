#include "engine/physics/network.h"

namespace tactus {
namespace {

std::size_t index(int i) { return static_cast<std::size_t>(i); }

double square(double x) { return x * x; }

/// The energy of a spring between two instants, in the form that each way of stepping it conserves.
double spring_energy(double stiffness, double extension, double before, bool averaged) {
  return 0.5 * stiffness * (averaged ? square(0.5 * (extension + before)) : extension * before);
}

}  // namespace

double Network::energy(const NetworkState& state) const noexcept {
  double sum = 0.0;
  for (std::size_t i = 0; i < mass_.size(); ++i) sum += 0.5 * mass_[i] * square(state.moved[i] / k_);
  for (const auto& s : springs_) {
    const auto lower = index(s.lower), upper = index(s.upper);
    const double extension = state.position[upper] - state.position[lower] - s.rest;
    const double before = extension - (state.moved[upper] - state.moved[lower]);
    sum += spring_energy(s.stiffness, extension, before, averaged_);
  }
  for (std::size_t c = 0; c < contacts_.size(); ++c) {
    const double n = indentation_now(state, contacts_[c]);
    if (solver_ == Solver::Passive)
      sum += 0.5 * square(state.root[c]);
    else if (n > 0.0)
      sum += contacts_[c].law.energy(n);
  }
  for (std::size_t i = 0; i < coils_.size(); ++i)
    sum += 0.5 * coils_[i].inductance * square(state.current[i]);
  return sum;
}

/// With d = q+ - q- of a point, a force F does the work F d/2 in a step. Called before `moved` is advanced.
void Network::audit(NetworkState& state) const noexcept {
  const auto travel = [&](int slot) { return state.moved[index(slot)] + 0.5 * state.change[index(slot)]; };
  const auto by_hand = [&](int slot) { return is_mass(slot) ? 0.0 : travel(slot); };
  for (std::size_t i = 0; i < forces_.size(); ++i) state.supplied += state.force[i] * travel(forces_[i].slot);
  for (const auto& s : springs_) {
    const auto lower = index(s.lower), upper = index(s.upper);
    const double speed = (travel(s.upper) - travel(s.lower)) / k_;
    double extension = state.position[upper] - state.position[lower] - s.rest;
    if (averaged_) extension += 0.25 * (state.change[upper] - state.change[lower]);
    const double tension = s.stiffness * extension + s.damping * speed;
    state.supplied += tension * (by_hand(s.upper) - by_hand(s.lower));
    state.dissipated += s.damping * speed * speed * k_;
  }
  for (const auto& touch : state.touching) {
    const auto& c = contacts_[index(touch.contact)];
    const double lost = touch.resistance - 0.25 * square(touch.slope);
    state.supplied += touch.force * (by_hand(c.lower) - by_hand(c.upper));
    state.dissipated += 0.5 * lost * square(touch.motion);
  }
  for (std::size_t i = 0; i < coils_.size(); ++i) {
    const auto& coil = coils_[i];
    const double force = coil.force_factor * state.mean_current[i];
    state.supplied += k_ * state.voltage[i] * state.mean_current[i];
    state.supplied += force * (by_hand(coil.against) - by_hand(coil.on));
    state.dissipated += k_ * coil.resistance * square(state.mean_current[i]);
  }
}

}  // namespace tactus
