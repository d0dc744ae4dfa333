#pragma once

#include <algorithm>
#include <cmath>

#include "engine/physics/network.h"

namespace tactus::test {

/// Adds up what goes into a network and what is lost in it [J], from the state before and after each step of
/// a solver that solves for A (one step a frame). With d = q+ - q- of a point a force F does the work F d/2.
class EnergyAudit {
 public:
  EnergyAudit(const NetworkElements& elements, int signals, Hertz rate)
      : model_(elements, signals, 1 / rate.value) {}

  double supplied = 0, dissipated = 0;

  void step(const Network& network, NetworkState& state, const double* inputs) {
    position_ = state.position, moved_ = state.moved, root_ = state.root, slipped_ = state.slipped;
    network.step(state, inputs);
    add_applied(state);
    add_springs(state, network.springs_averaged());
    add_couplings(state, network.solver());
    add_coils(state);
  }

 private:
  double way(const NetworkState& after, int slot) const {
    return 0.5 * (moved_[index(slot)] + after.moved[index(slot)]);
  }
  /// Of a point that is driven.
  double by_hand(const NetworkState& after, int slot) const {
    return model_.is_mass(slot) ? 0.0 : way(after, slot);
  }

  void add_applied(const NetworkState& after) {
    for (std::size_t i = 0; i < model_.forces.size(); ++i)
      supplied += after.force[i] * way(after, model_.forces[i].on);
    for (std::size_t i = 0; i < model_.ports.size(); ++i) {
      const double moved = way(after, model_.ports[i].on);
      supplied += 2.0 * after.wave[i] * moved;
      dissipated += model_.ports[i].impedance * square(moved) / model_.k;
    }
  }

  void add_springs(const NetworkState& after, bool averaged) {
    for (const auto& s : model_.springs) {
      const double speed = (way(after, s.upper) - way(after, s.lower)) / model_.k;
      double stretch = extension(position_, s);
      if (averaged) stretch += 0.25 * (between(moved_, s) - between(after.moved, s));
      const double tension = s.stiffness * stretch + s.damping * speed;
      supplied += tension * (by_hand(after, s.upper) - by_hand(after, s.lower));
      dissipated += s.damping * speed * speed * model_.k;
    }
  }

  template <class Link>
  void add_pushed(const NetworkState& after, const Link& link, double force) {
    supplied += force * (by_hand(after, link.lower) - by_hand(after, link.upper));
  }

  void add_couplings(const NetworkState& after, Solver solver) {
    const auto contacts = model_.contacts.size();
    for (const auto& link : after.active) {
      const auto c = index(link.coupling);
      if (c < contacts)
        add_pushed(after, model_.contacts[c], link.force);
      else
        add_pushed(after, model_.bonds[c - contacts], link.force);
      const double quadratised = 0.5 * (link.resistance - 0.25 * square(link.slope)) * square(link.motion);
      dissipated += solver == Solver::Implicit && c < contacts ? lost(link) : quadratised;
      if (c >= contacts && slipped_[c - contacts] == 0.0 && after.slipped[c - contacts] != 0.0)
        dissipated += 0.5 * square(root_[c] + 0.5 * link.slope * link.motion);
    }
    for (std::size_t f = 0; f < model_.frictions.size(); ++f) {
      const auto& friction = model_.frictions[f];
      const double force = after.friction_force[f];
      add_pushed(after, friction, force);
      dissipated += force * (way(after, friction.lower) - way(after, friction.upper));
    }
  }

  /// By a contact with the discrete gradient.
  double lost(const ActiveCoupling& link) const {
    const auto& contact = model_.contacts[index(link.coupling)];
    const auto energy = [&](double n) { return n > 0.0 ? contact.law.energy(n) : 0.0; };
    const double before = indentation(position_, contact) - between(moved_, contact);
    return 0.5 * (link.force * link.motion - (energy(before + link.motion) - energy(before)));
  }

  void add_coils(const NetworkState& after) {
    for (std::size_t i = 0; i < model_.coils.size(); ++i) {
      const auto& coil = model_.coils[i];
      const double current = after.mean_current[i], force = coil.force_factor * current;
      supplied += model_.k * after.voltage[i] * current;
      supplied += force * (by_hand(after, coil.against) - by_hand(after, coil.on));
      dissipated += model_.k * coil.resistance * square(current);
    }
  }

  NetworkModel model_;
  AlignedNumbers position_, moved_, root_, slipped_;  ///< before the step
};

}  // namespace tactus::test
