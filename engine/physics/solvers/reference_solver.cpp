#include "engine/physics/solvers/reference_solver.h"

#include <algorithm>
#include <cmath>

#include "engine/core/index.h"

namespace tactus {
namespace {

/// The same elements with the slots of the model for their points.
NetworkElements in_slots(const NetworkModel& model, NetworkElements elements) {
  std::vector<Point> points(model.start_position.size());
  for (auto& point : points) point.kind = Point::Kind::Ground;
  for (std::size_t i = 0; i < elements.points.size(); ++i) points[index(model.slot[i])] = elements.points[i];
  elements.points = std::move(points);
  renumber(elements, model.slot);
  return elements;
}

}  // namespace

ReferenceSolver::ReferenceSolver(const NetworkModel& model, const NetworkElements& elements)
    : model_(model), flow_(in_slots(model, elements), Seconds{model.k}), now_(flow_.initial()) {}

void ReferenceSolver::start(NetworkState& state) const noexcept {
  const auto motions = state.position.data() + model_.masses;
  flow_.reset(now_, {motions, model_.motions.size()});
  std::copy_n(model_.start_velocity.begin(), state.velocity.size(), state.velocity.begin());
  std::copy(now_.loss.begin(), now_.loss.end(), state.loss.begin());
}

/// Which contacts press follows from how deep they are and how fast that changes.
void ReferenceSolver::load(const NetworkState& state) const noexcept {
  const auto all = (now_.numbers.size() - state.current.size()) / 2;
  std::copy(state.position.begin(), state.position.end(), now_.numbers.begin());
  std::copy(state.velocity.begin(), state.velocity.end(),
            now_.numbers.begin() + static_cast<std::ptrdiff_t>(all));
  std::copy(state.current.begin(), state.current.end(),
            now_.numbers.end() - static_cast<std::ptrdiff_t>(state.current.size()));
  std::copy(state.loss.begin(), state.loss.end(), now_.loss.begin());
  std::copy(state.sliding.begin(), state.sliding.end(), now_.slide.begin());
  std::copy(state.slipped.begin(), state.slipped.end(), now_.slide.end() - std::ssize(state.slipped));
  flow_.find_contacts(now_);
}

void ReferenceSolver::keep(NetworkState& state) const noexcept {
  const auto slots = state.position.size();
  for (std::size_t i = 0; i < slots; ++i) {
    const int slot = static_cast<int>(i);
    state.change[i] = flow_.position(now_, slot) - state.position[i];
    state.position[i] = flow_.position(now_, slot);
    state.velocity[i] = flow_.velocity(now_, slot);
  }
  for (std::size_t i = 0; i < state.current.size(); ++i)
    state.current[i] = state.mean_current[i] = flow_.current(now_, static_cast<int>(i));
  std::copy(now_.loss.begin(), now_.loss.end(), state.loss.begin());
  for (std::size_t f = 0; f < state.sliding.size(); ++f) {
    state.sliding[f] = now_.slide[f];
    state.friction_force[f] = flow_.friction_force(now_, static_cast<int>(f));
    state.friction_velocity[f] = flow_.friction_velocity(now_, static_cast<int>(f));
  }
  for (std::size_t p = 0; p < state.slipped.size(); ++p) {
    const auto& bond = model_.bonds[p];
    state.slipped[p] = now_.slide[state.sliding.size() + p];
    state.root[model_.contacts.size() + p] =
        bond.law->root(state.position[index(bond.lower)] - state.position[index(bond.upper)]);
  }
  for (std::size_t p = 0; p < state.wave_back.size(); ++p) {
    const auto& port = model_.ports[p];
    state.wave_back[p] += state.wave[p] - port.impedance * state.change[index(port.wave.slot)] / model_.k;
  }
}

void ReferenceSolver::step(NetworkState& state) const noexcept {
  load(state);
  const std::span<const double> places{state.position.data() + model_.masses, model_.motions.size()};
  flow_.advance(now_, {.forces = state.force,
                       .voltages = state.voltage,
                       .waves = state.wave,
                       .normals = state.normal,
                       .motion_from = places,
                       .motion_to = state.next});
  keep(state);
}

double ReferenceSolver::energy(const NetworkState& state) const noexcept {
  load(state);
  return flow_.energy(now_);
}

double ReferenceSolver::velocity(const NetworkState& state, int slot) const noexcept {
  return state.velocity[index(slot)];
}

double ReferenceSolver::current(const NetworkState& state, int coil) const noexcept {
  return state.current[index(coil)];
}

}  // namespace tactus
