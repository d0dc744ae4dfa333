#include "engine/study/work_precision/methods/motion.h"

#include <algorithm>

#include "engine/core/index.h"

namespace tactus {
namespace {

constexpr double kContactMultiplications = 15.0;  // as the explicit solver counts a power law
constexpr double kSlowest_m_per_s = 1e-4;         // the reference closes no contact more slowly

}  // namespace

Motion::Motion(const NetworkModel& model) : model_(model), loss_(model.contacts.size()) {
  int rows = model.masses;
  for (const auto& coil : model.coils) charge_.push_back(coil.inductance > 0.0 ? rows++ : -1);
  mass_.resize(rows);
  for (int i = 0; i < model.masses; ++i) mass_[i] = model.mass[index(i)];
  for (std::size_t c = 0; c < charge_.size(); ++c)
    if (charge_[c] >= 0) mass_[charge_[c]] = model.coils[c].inductance;
  x_ = v_ = entering_ = Vector::Zero(rows);
}

double Motion::place(double share, const Vector& x, int slot) const {
  if (model_.is_mass(slot)) return x[slot];
  const auto driven = index(slot - model_.masses);
  return model_.moves(slot) ? from_[driven] + share * (to_[driven] - from_[driven])
                            : model_.start_position[index(slot)];
}

double Motion::speed(const Vector& v, int slot) const {
  if (model_.is_mass(slot)) return v[slot];
  const auto driven = index(slot - model_.masses);
  return model_.moves(slot) ? (to_[driven] - from_[driven]) / model_.k : 0.0;
}

/// Pushes `lower` down and `upper` up.
void Motion::push(int lower, int upper, double by, Vector& force) const {
  if (model_.is_mass(lower)) force[lower] -= by;
  if (model_.is_mass(upper)) force[upper] += by;
}

template <class Add>
void Motion::each_damper(Add add) const {
  for (const auto& s : model_.springs)
    if (s.damping > 0.0) add(s.lower, s.upper, s.damping);
  for (const auto& c : model_.coils)
    if (!(c.inductance > 0.0)) add(c.on, c.against, c.force_factor * c.force_factor / c.resistance);
}

void Motion::begin(NetworkState& state) {
  for (int i = 0; i < model_.masses; ++i) {
    x_[i] = state.position[index(i)];
    v_[i] = state.velocity[index(i)];
  }
  for (std::size_t c = 0; c < charge_.size(); ++c)
    if (charge_[c] >= 0) v_[charge_[c]] = state.current[c];
  from_.assign(state.position.begin() + model_.masses,
               state.position.begin() + model_.masses + std::ssize(model_.motions));
  to_.assign(state.next.begin(), state.next.end());
  entering_.setZero();
  const auto enter = [&](int slot, double force) {
    if (model_.is_mass(slot)) entering_[slot] += force;
  };
  for (std::size_t i = 0; i < model_.forces.size(); ++i) enter(model_.forces[i].on, state.force[i]);
  for (std::size_t i = 0; i < model_.ports.size(); ++i) enter(model_.ports[i].on, 2.0 * state.wave[i]);
  for (std::size_t i = 0; i < model_.coils.size(); ++i) {
    const auto& coil = model_.coils[i];
    if (charge_[i] >= 0) {
      entering_[charge_[i]] += state.voltage[i];
    } else {
      const double force = coil.force_factor * state.voltage[i] / coil.resistance;
      enter(coil.on, force);
      enter(coil.against, -force);
    }
  }
  for (std::size_t c = 0; c < model_.contacts.size(); ++c) {
    const auto& contact = model_.contacts[c];
    const double depth = place(0.0, x_, contact.lower) - place(0.0, x_, contact.upper) + contact.offset;
    const double closing = speed(v_, contact.lower) - speed(v_, contact.upper);
    if (contact.loss_speed == 0.0)
      loss_[c] = contact.loss;
    else if (depth <= 0.0 || loss_[c] == 0.0)
      loss_[c] = contact.loss_speed / std::max(closing, kSlowest_m_per_s);
  }
  state.loss.assign(loss_.begin(), loss_.end());
}

void Motion::linear_force(double share, const Vector& x, const Vector& v, Vector& force) {
  force.setZero(size());
  for (const auto& s : model_.springs) {
    const double extension = place(share, x, s.upper) - place(share, x, s.lower) - s.rest;
    push(s.upper, s.lower, s.stiffness * extension, force);
  }
  each_damper([&](int lower, int upper, double damping) {
    push(upper, lower, damping * (speed(v, upper) - speed(v, lower)), force);
    count(1);
  });
  for (const auto& port : model_.ports)
    if (model_.is_mass(port.on)) force[port.on] -= port.impedance * v[port.on];
  for (std::size_t i = 0; i < charge_.size(); ++i) {
    if (charge_[i] < 0) continue;
    const auto& coil = model_.coils[i];
    const double current = v[charge_[i]];
    push(coil.against, coil.on, coil.force_factor * current, force);
    force[charge_[i]] -=
        coil.resistance * current + coil.force_factor * (speed(v, coil.on) - speed(v, coil.against));
    count(3);
  }
  count(static_cast<double>(model_.springs.size() + model_.ports.size()));
}

template <class Each>
bool Motion::each_closed(double share, const Vector& x, const Vector& v, Each each) {
  bool any = false;
  for (std::size_t c = 0; c < model_.contacts.size(); ++c) {
    const auto& contact = model_.contacts[c];
    const double depth = place(share, x, contact.lower) - place(share, x, contact.upper) + contact.offset;
    if (!(depth > 0.0)) continue;
    any = true;
    count(kContactMultiplications);
    each(Closed{&contact, depth, speed(v, contact.lower) - speed(v, contact.upper), loss_[c]});
  }
  return any;
}

bool Motion::add_contacts(double share, const Vector& x, const Vector& v, Vector& force) {
  return each_closed(share, x, v, [&](const Closed& c) {
    const double by = c.contact->law.force(c.depth) * (1.0 + c.loss * c.speed);
    push(c.contact->lower, c.contact->upper, std::max(0.0, by), force);
  });
}

namespace {

/// Of a link whose force falls by `stiffness` per way of `lower` and rises by as much for `upper`.
void add_link(const NetworkModel& model, int lower, int upper, double slope, int row, int column,
              Motion::Triplets& entries) {
  for (const auto& [one, other] : {std::pair{lower, upper}, {upper, lower}}) {
    if (!model.is_mass(one)) continue;
    entries.emplace_back(row + one, column + one, slope);
    if (model.is_mass(other)) entries.emplace_back(row + one, column + other, -slope);
  }
}

}  // namespace

void Motion::add_linear_slopes(double a, double b, int row, int column, Triplets& entries) const {
  for (const auto& s : model_.springs)
    add_link(model_, s.lower, s.upper, a * s.stiffness, row, column, entries);
  each_damper([&](int lower, int upper, double damping) {
    add_link(model_, lower, upper, b * damping, row, column, entries);
  });
  for (const auto& port : model_.ports)
    if (model_.is_mass(port.on)) entries.emplace_back(row + port.on, column + port.on, b * port.impedance);
  for (std::size_t i = 0; i < charge_.size(); ++i) {
    const int charge = charge_[i];
    if (charge < 0) continue;
    const auto& coil = model_.coils[i];
    entries.emplace_back(row + charge, column + charge, b * coil.resistance);
    for (const auto& [slot, factor] :
         {std::pair{coil.on, coil.force_factor}, {coil.against, -coil.force_factor}}) {
      if (!model_.is_mass(slot)) continue;
      entries.emplace_back(row + charge, column + slot, b * factor);
      entries.emplace_back(row + slot, column + charge, -b * factor);
    }
  }
}

void Motion::add_contact_slopes(double share, const Vector& x, const Vector& v, double a, double b, int row,
                                int column, Triplets& entries) {
  each_closed(share, x, v, [&](const Closed& c) {
    const double rate = 1.0 + c.loss * c.speed;
    if (rate <= 0.0) return;
    const double slope =
        a * c.contact->law.stiffness(c.depth) * rate + b * c.contact->law.force(c.depth) * c.loss;
    add_link(model_, c.contact->lower, c.contact->upper, slope, row, column, entries);
  });
}

double Motion::contact_energy(const Vector& x, Vector& slopes, const std::vector<double>& before,
                              double& driven) {
  double energy = 0.0;
  driven = 0.0;
  slopes.setZero(size());
  const auto way = [&](int slot) {
    if (model_.is_mass(slot) || !model_.moves(slot)) return 0.0;
    const auto motion = index(slot - model_.masses);
    return to_[motion] - before[motion];
  };
  each_closed(0.0, x, v_, [&](const Closed& c) {
    const double force = c.contact->law.force(c.depth);
    energy += c.contact->law.energy(c.depth);
    // The force pushes against the slope.
    push(c.contact->lower, c.contact->upper, -force, slopes);
    driven += force * (way(c.contact->lower) - way(c.contact->upper));
  });
  return energy;
}

void Motion::add_losses(const Vector& x, const Vector& v, Vector& force) {
  each_closed(0.0, x, v, [&](const Closed& c) {
    const double by = c.contact->law.force(c.depth) * std::max(-1.0, c.loss * c.speed);
    push(c.contact->lower, c.contact->upper, by, force);
  });
}

void Motion::end(const Vector& x, const Vector& v, NetworkState& state) {
  model_.send_waves(state, [&](int slot) { return place(1.0, x, slot) - place(0.0, x_, slot); });
  for (int i = 0; i < model_.masses; ++i) {
    state.position[index(i)] = x[i];
    state.velocity[index(i)] = v[i];
  }
  for (std::size_t i = 0; i < model_.motions.size(); ++i) {
    const auto slot = index(model_.motions[i].on);
    state.position[slot] = to_[i];
    state.velocity[slot] = (to_[i] - from_[i]) / model_.k;
  }
  for (std::size_t c = 0; c < charge_.size(); ++c)
    if (charge_[c] >= 0) state.current[c] = v[charge_[c]];
}

double Motion::current(const NetworkState& state, int coil) const {
  const auto& c = model_.coils[index(coil)];
  if (charge_[index(coil)] >= 0) return state.current[index(coil)];
  const double apart = state.velocity[index(c.on)] - state.velocity[index(c.against)];
  return (state.voltage[index(coil)] - c.force_factor * apart) / c.resistance;
}

double Motion::energy(const NetworkState& state) const {
  double sum = model_.linear_energy(state);
  for (const auto& contact : model_.contacts)
    if (const double depth = indentation(state.position, contact); depth > 0.0)
      sum += contact.law.energy(depth);
  return model_.with_inductances(sum, state);
}

}  // namespace tactus
