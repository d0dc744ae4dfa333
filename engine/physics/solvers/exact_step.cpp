#include <cmath>

#include "engine/physics/index.h"
#include "engine/physics/solvers/exact_scheme.h"

namespace tactus {
namespace {

using View = Eigen::Map<Eigen::VectorXd>;

}  // namespace

void ExactScheme::start(NetworkState& state) const noexcept {
  std::copy(model_.start_velocity.begin(), model_.start_velocity.end(), state.velocity.begin());
  for (std::size_t c = 0; c < model_.contacts.size(); ++c) {
    const auto& contact = model_.contacts[c];
    const auto lower = index(contact.lower), upper = index(contact.upper);
    const double n = state.position[lower] - state.position[upper] + contact.offset;
    state.loss[c] = contact.loss;
    if (n > 0.0)
      watch_touch(model_, state, c, n,
                  std::max(n, model_.k * (state.velocity[lower] - state.velocity[upper])));
  }
  store_energy(state);
}

void ExactScheme::store_energy(NetworkState& state) const noexcept { couplings_.store_energy(state); }

void ExactScheme::step(NetworkState& state) const noexcept {
  for (std::size_t i = 0; i < model_.motions.size(); ++i) {
    const auto slot = index(model_.motions[i].slot);
    state.change[slot] = state.next[i] - state.position[slot];
  }
  for (const auto& block : blocks_) flow(state, block);
  if (!couplings_.empty()) {
    couplings_.solve(state);
    push(state);
    couplings_.finish(state);
  }
  send_waves(state);
  for (const auto& block : blocks_) arrive(state, block);
  for (std::size_t i = 0; i < model_.motions.size(); ++i) {
    const auto slot = index(model_.motions[i].slot);
    state.velocity[slot] = state.change[slot] / model_.k;
    state.position[slot] = state.next[i];
  }
}

double ExactScheme::input(const NetworkState& state, const Input& from) const noexcept {
  const auto source = index(from.source);
  switch (from.from) {
    case Input::From::Force:
      return state.force[source];
    case Input::From::Voltage:
      return state.voltage[source];
    case Input::From::Wave:
      return state.wave[source];
    case Input::From::Place:
      return state.position[index(model_.motions[source].slot)];
    case Input::From::Way:
      break;
  }
  return state.change[index(model_.motions[source].slot)];
}

/// Where the group goes without its couplings.
void ExactScheme::flow(NetworkState& state, const Block& block) const noexcept {
  const auto masses = block.group.masses.size();
  double* x = state.entering.data();
  for (std::size_t i = 0; i < masses; ++i) {
    x[i] = state.position[index(block.group.masses[i])];
    x[masses + i] = model_.k * state.velocity[index(block.group.masses[i])];
  }
  x += 2 * masses;
  for (const int coil : block.group.coils) *x++ = state.current[index(coil)];
  for (const auto& from : block.inputs) *x++ = input(state, from);
  View to(state.flow.data() + block.first, block.group.states());
  to = block.constant;
  to.noalias() += block.step * View(state.entering.data(), block.step.cols());
  for (std::size_t i = 0; i < masses; ++i)
    state.change[index(block.group.masses[i])] =
        to[static_cast<Eigen::Index>(i)] - state.position[index(block.group.masses[i])];
}

void ExactScheme::push(NetworkState& state) const noexcept {
  couplings_.push_all(state, [&](int slot, double force) {
    if (!model_.is_mass(slot) || force == 0.0) return;
    const auto& [at, row] = places_[index(slot)];
    const auto& block = blocks_[index(at)];
    View(state.flow.data() + block.first, block.group.states()) += force * block.unit.col(row);
  });
  for (std::size_t slot = 0; slot < places_.size(); ++slot) {
    const auto& [at, row] = places_[slot];
    state.change[slot] = state.flow[index(blocks_[index(at)].first + row)] - state.position[slot];
  }
}

void ExactScheme::arrive(NetworkState& state, const Block& block) const noexcept {
  const double* x = state.flow.data() + block.first;
  for (const int slot : block.group.masses) state.position[index(slot)] = *x++;
  for (const int slot : block.group.masses) state.velocity[index(slot)] = *x++ / model_.k;
  for (const int coil : block.group.coils) state.current[index(coil)] = *x++;
}

void ExactScheme::send_waves(NetworkState& state) const noexcept {
  for (std::size_t i = 0; i < model_.ports.size(); ++i) {
    const auto& port = model_.ports[i];
    state.wave_back[i] += state.wave[i] - port.impedance * state.change[index(port.wave.slot)] / model_.k;
  }
}

double ExactScheme::velocity(const NetworkState& state, int slot) const noexcept {
  return state.velocity[index(slot)];
}

double ExactScheme::current(const NetworkState& state, int coil) const noexcept {
  const auto& c = model_.coils[index(coil)];
  if (c.inductance > 0.0) return state.current[index(coil)];
  const double speed = state.velocity[index(c.on)] - state.velocity[index(c.against)];
  return (state.voltage[index(coil)] - c.force_factor * speed) / c.resistance;
}

double ExactScheme::energy(const NetworkState& state) const noexcept {
  double sum = 0.0;
  for (std::size_t i = 0; i < model_.mass.size(); ++i)
    sum += 0.5 * model_.mass[i] * square(state.velocity[i]);
  for (const auto& s : model_.springs)
    sum +=
        0.5 * s.stiffness * square(state.position[index(s.upper)] - state.position[index(s.lower)] - s.rest);
  for (const double root : state.root) sum += 0.5 * square(root);
  for (std::size_t i = 0; i < model_.coils.size(); ++i)
    sum += 0.5 * model_.coils[i].inductance * square(state.current[i]);
  return sum;
}

Scheme::Cost ExactScheme::cost() const {
  double step = 4.0 * static_cast<double>(couplings_.count()), touch = 40.0;
  for (const auto& block : blocks_) {
    step += static_cast<double>(block.step.size());
    touch += block.group.states();
  }
  return {step, touch};
}

}  // namespace tactus
