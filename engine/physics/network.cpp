#include "engine/physics/network.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <initializer_list>

#include "engine/core/index.h"
#include "engine/dsp/simd/lanes.h"
#include "engine/physics/solvers/solver_tables.h"

namespace tactus {
namespace {

/// What enters at frame n; nothing is connected to signal -1.
double now(const NetworkInput& input, const double* inputs) {
  return input.signal < 0 ? 0.0 : inputs[input.signal];
}
double before(const NetworkState& state, const NetworkInput& input) {
  return input.signal < 0 ? 0.0 : state.held[index(input.signal)];
}

Result<std::unique_ptr<NetworkSolver>> make_solver(const NetworkModel& model, Solver solver) {
  if (solver == Solver::Exact) return make_exact_solver(model);
  if (solver == Solver::Reference) return make_reference_solver(model);
  return make_centred_solver(model, solver);
}

/// Calls `each(one, other)` with the places of what both have. Both rise.
template <class Each>
void pair(const std::vector<int>& mine, const std::vector<int>& theirs, Each each) {
  std::size_t from = 0;
  for (std::size_t to = 0; to < mine.size(); ++to) {
    while (from < theirs.size() && theirs[from] < mine[to]) ++from;
    if (from < theirs.size() && theirs[from] == mine[to]) each(to, from);
  }
}

Status check_springs(const NetworkElements& elements, Solver solver, double step_s) {
  if (solver == Solver::Explicit || solver == Solver::Reference || elements.contacts.empty()) return {};
  for (const auto& strike : contact_demand(elements).strikes)
    if (strike.spring && strike.time_s < kShortestSpring * step_s)
      return fail(Errc::OutOfRange, {},
                  "a cubic spring, or a contact that closes as its opposite opens, is too stiff: half a "
                  "period lasts less than a hundredth of a step",
                  "lower its 'cubic' or 'stiffness', or start closer to its rest");
  return {};
}

}  // namespace

SolverTables NetworkSolver::tables() const { return {}; }

Result<Network> Network::make(const NetworkElements& elements, int signals, Hertz rate, Solver solver,
                              int oversample) {
  assert(rate.value > 0.0 && oversample >= 0);
  Network network;
  network.choice_ = solver == Solver::Auto ? choose_solver(elements, rate, oversample)
                                           : SolverChoice{solver, std::max(1, oversample), {}};
  const double step_s = 1.0 / (rate.value * network.oversample());
  if (auto fits = check_springs(elements, network.solver(), step_s); !fits)
    return tl::unexpected(fits.error());
  network.model_ = std::make_shared<const NetworkModel>(elements, signals, step_s);
  auto made = make_solver(*network.model_, network.solver());
  if (!made) return tl::unexpected(made.error());
  network.network_solver_ = std::move(*made);
  return network;
}

Network Network::make(const NetworkElements& elements, int signals, Hertz rate, int oversample,
                      const MakeSolver& make_solver) {
  Network network;
  network.choice_ = {Solver::Reference, oversample, {}};
  const double step_s = 1.0 / (rate.value * oversample);
  network.model_ = std::make_shared<const NetworkModel>(elements, signals, step_s);
  network.network_solver_ = make_solver(*network.model_);
  return network;
}

NetworkState Network::initial_state() const {
  const auto& m = *model_;
  NetworkState state;
  const auto slots = m.start_position.size(), couplings = m.contacts.size() + m.bonds.size();
  for (auto* list : {&state.position, &state.change}) list->resize(slots);
  if (network_solver_->centred())
    state.moved.resize(slots), state.moved_before.resize(slots);
  else
    state.velocity.resize(slots);
  state.root.resize(couplings);
  state.loss.resize(m.contacts.size());
  state.active.reserve(couplings);
  if (solver() != Solver::Explicit) state.matrix.resize(couplings * couplings);
  state.right.resize(couplings);
  if (m.has_lines())  // with a force and a motion of each row
    state.along.resize(kMostAxes * m.bonds.size() +
                       2 * (m.contacts.size() + kMostAxes * m.bonds.size() + m.frictions.size()));
  state.slipped.resize(m.bonds.size());
  for (auto* list : {&state.sliding, &state.friction_force, &state.friction_velocity, &state.normal})
    list->resize(m.frictions.size());
  state.friction.resize(m.frictions.size());
  state.rubbed.resize(m.frictions.size());
  for (auto* list : {&state.current, &state.mean_current, &state.voltage}) list->resize(m.coils.size());
  state.force.resize(m.forces.size());
  for (auto* list : {&state.wave, &state.wave_back}) list->resize(m.ports.size());
  state.low_pass.resize(m.low_passes.size());
  state.new_low_pass.resize(m.low_passes.size());
  state.new_motion.resize(m.motions.size());
  state.new_bond.resize(m.bonds.size());
  state.next.resize(m.motions.size());
  state.held.resize(index(m.signals));
  for (auto* list : {&state.flow, &state.work}) list->resize(2 * m.mass.size() + m.coils.size());
  state.entering.resize(2 * m.mass.size() + m.forces.size() + 2 * m.coils.size() + m.ports.size() +
                        2 * m.motions.size());
  reset(state);
  return state;
}

void Network::reset(NetworkState& state) const noexcept {
  std::copy(model_->start_position.begin(), model_->start_position.end(), state.position.begin());
  for (const auto list : NetworkState::memory())
    if (list != &NetworkState::position) std::fill((state.*list).begin(), (state.*list).end(), 0.0);
  std::fill(state.change.begin(), state.change.end(), 0.0);
  std::fill(state.low_pass.begin(), state.low_pass.end(), CriticalLowPass::State{});
  std::fill(state.friction.begin(), state.friction.end(), FrictionMemory{});
  for (std::size_t f = 0; f < model_->frictions.size(); ++f) {
    const double v = between(model_->start_velocity, model_->frictions[f]);
    state.sliding[f] = v > 0.0 ? 1.0 : v < 0.0 ? -1.0 : 0.0;
  }
  state.active.clear();
  for (auto* list : {&state.new_motion, &state.new_low_pass, &state.new_bond})
    std::fill(list->begin(), list->end(), true);
  state.started = state.settled = false;
  network_solver_->start(state);
}

StateOrigins Network::origins(const PartNumbers& parts, const std::vector<int>& signals) const {
  const auto& m = *model_;
  StateOrigins origins{{},
                       parts[PartKind::Contact],
                       parts[PartKind::Bond],
                       parts[PartKind::Friction],
                       parts[PartKind::Coil],
                       parts[PartKind::Force],
                       parts[PartKind::Port],
                       signals,
                       {}};
  // Masses before driven points, low-passes by what they lead to: each kind has its own range.
  constexpr int kRange = 1 << 28;
  origins.moving.resize(m.masses + m.motions.size());
  for (std::size_t p = 0; p < parts[PartKind::Point].size(); ++p)
    if (const int slot = m.slot[p]; m.moves(slot))
      origins.moving[index(slot)] = parts[PartKind::Point][p] + (m.is_mass(slot) ? 0 : kRange);
  origins.low_passes.resize(m.low_passes.size());
  int range = 0;
  const auto add = [&](const NetworkInput& input) {
    if (input.low_pass >= 0) origins.low_passes[index(input.low_pass)] = signals[index(input.signal)] + range;
  };
  for (const auto& motion : m.motions) add(motion.input);
  range = kRange;
  for (const auto& force : m.forces) add(force.input);
  return origins;
}

void Network::adopt(NetworkState& state, const StateOrigins& origins, const Before& before) const noexcept {
  if (!before.state.started) return;
  using List = AlignedNumbers NetworkState::*;
  const auto& old = before.state;
  const auto& was = before.origins;
  const auto take = [&](std::initializer_list<List> lists, const std::vector<int>& mine,
                        const std::vector<int>& theirs) {
    pair(mine, theirs, [&](std::size_t to, std::size_t from) {
      for (const auto list : lists) (state.*list)[to] = (old.*list)[from];
    });
  };
  using S = NetworkState;
  pair(origins.moving, was.moving, [&](std::size_t to, std::size_t from) {
    adopt_motion(state, static_cast<int>(to), before, static_cast<int>(from));
  });
  take({&S::loss}, origins.contacts, was.contacts);
  pair(origins.bonds, was.bonds, [&](std::size_t to, std::size_t from) {
    state.slipped[to] = old.slipped[from];
    state.new_bond[to] = old.new_bond[from];
  });
  take({&S::sliding, &S::friction_force, &S::friction_velocity, &S::normal}, origins.frictions,
       was.frictions);
  take({&S::current, &S::mean_current, &S::voltage}, origins.coils, was.coils);
  take({&S::force}, origins.forces, was.forces);
  take({&S::wave, &S::wave_back}, origins.ports, was.ports);
  take({&S::held}, origins.signals, was.signals);
  pair(origins.frictions, was.frictions,
       [&](std::size_t to, std::size_t from) { state.friction[to] = old.friction[from]; });
  pair(origins.low_passes, was.low_passes, [&](std::size_t to, std::size_t from) {
    state.low_pass[to] = old.low_pass[from];
    state.new_low_pass[to] = old.new_low_pass[from];
  });
  const auto none = [](const std::vector<bool>& list) {
    return std::find(list.begin(), list.end(), true) == list.end();
  };
  state.started = true;
  state.settled = none(state.new_motion) && none(state.new_low_pass) && none(state.new_bond);
  network_solver_->store_energy(state);
}

/// Solvers keep a motion as a velocity, or as the way of the last step, however long that is.
void Network::adopt_motion(NetworkState& state, int slot, const Before& before, int from) const noexcept {
  const auto to = index(slot), of = index(from);
  const auto& old = before.state;
  state.position[to] = old.position[of];
  if (!model_->is_mass(slot))
    state.new_motion[index(slot - model_->masses)] =
        old.new_motion[index(from - before.network.model_->masses)];
  if (!network_solver_->centred()) {
    state.velocity[to] = before.network.network_solver_->velocity(old, from);
  } else if (before.network.network_solver_->centred()) {
    const double longer = model_->k / before.network.model_->k;
    state.moved[to] = longer * old.moved[of];
    state.moved_before[to] = longer * old.moved_before[of];
  } else {
    state.moved[to] = state.moved_before[to] = model_->k * old.velocity[of];
  }
}

/// Driven points and hands do not jump to their first place, they have been there before the start.
void Network::settle(NetworkState& state, const double* inputs) const noexcept {
  for (std::size_t i = 0; i < model_->motions.size(); ++i) {
    const auto& [on, input] = model_->motions[i];
    const double place = now(input, inputs);
    if (!state.new_motion[i]) continue;
    state.new_motion[i] = false;
    state.position[index(on)] = place;
    for (auto* list : {&state.moved, &state.moved_before})
      if (!list->empty()) (*list)[index(on)] = 0.0;
    if (input.signal >= 0) state.held[index(input.signal)] = place;
    settle_low_pass(state, input, inputs);
  }
  for (const auto& force : model_->forces) settle_low_pass(state, force.input, inputs);
  for (std::size_t b = 0; b < model_->bonds.size(); ++b) {
    const auto& bond = model_->bonds[b];
    const double n = stretch(state.position, bond);
    if (state.new_bond[b] && std::abs(bond.law->force(n)) > bond.limit)
      state.slipped[b] = n < 0.0 ? -1.0 : 1.0;
    state.new_bond[b] = false;
  }
  if (state.started)
    network_solver_->store_energy(state);  // what was there before goes on
  else
    network_solver_->start(state);
  state.started = state.settled = true;
}

void Network::settle_low_pass(NetworkState& state, const NetworkInput& input,
                              const double* inputs) const noexcept {
  if (input.low_pass < 0 || !state.new_low_pass[index(input.low_pass)]) return;
  state.low_pass[index(input.low_pass)] = {now(input, inputs), 0.0};
  state.new_low_pass[index(input.low_pass)] = false;
}

void Network::step(NetworkState& state, const double* inputs) const noexcept {
  if (!state.settled) settle(state, inputs);
  for (auto& wave : state.wave_back) wave = 0.0;
  for (int part = 0; part < oversample(); ++part) substep(state, inputs, part);
  for (auto& wave : state.wave_back) wave /= oversample();
  copy_samples(inputs, model_->signals, state.held.data());
}

/// A value held from frame to frame, as the solver sees it in step `part` of a frame.
double Network::enter(NetworkState& state, const NetworkInput& input, const double* inputs,
                      int part) const noexcept {
  const double value = now(input, inputs);
  if (input.low_pass >= 0) {
    auto& filter = state.low_pass[index(input.low_pass)];
    const double filtered = filter.value;
    model_->low_passes[index(input.low_pass)].step(filter, value);
    return filtered;
  }
  return part == 0 && network_solver_->centred() ? 0.5 * (before(state, input) + value) : value;
}

void Network::substep(NetworkState& state, const double* inputs, int part) const noexcept {
  if (!model_->motions.empty()) move_driven(state, inputs, part);
  for (std::size_t i = 0; i < model_->forces.size(); ++i)
    state.force[i] = enter(state, model_->forces[i].input, inputs, part);
  for (std::size_t i = 0; i < model_->coils.size(); ++i)
    state.voltage[i] = enter(state, model_->coils[i].voltage, inputs, part);
  for (std::size_t i = 0; i < model_->ports.size(); ++i)
    state.wave[i] = now(model_->ports[i].wave, inputs);  // a sample of a wave, not a held force
  if (!model_->frictions.empty()) press(state, inputs, part);
  network_solver_->step(state);
}

void Network::move_driven(NetworkState& state, const double* inputs, int part) const noexcept {
  for (std::size_t i = 0; i < model_->motions.size(); ++i) {
    const auto& input = model_->motions[i].input;
    double next = now(input, inputs);
    if (input.low_pass >= 0) {
      auto& filter = state.low_pass[index(input.low_pass)];
      model_->low_passes[index(input.low_pass)].step(filter, next);
      next = filter.value;
    } else if (part + 1 < oversample()) {
      const double last = before(state, input);
      next = last + (next - last) * (part + 1) / oversample();
    }
    state.next[i] = next;
  }
}

/// Normal forces: of a signal, or what another link does by now. In the first step a signal has no value
/// before that it would be the mean with: what is pressed has been pressed before the start.
void Network::press(NetworkState& state, const double* inputs, int part) const noexcept {
  for (std::size_t f = 0; f < model_->frictions.size(); ++f) {
    const auto& friction = model_->frictions[f];
    const bool first = state.friction[f].margin == FrictionMemory::kStart && friction.normal.low_pass < 0;
    state.normal[f] = friction.normal_contact >= 0  ? contact_force(state, friction.normal_contact)
                      : friction.normal_spring >= 0 ? spring_force(state, friction.normal_spring)
                      : first                       ? now(friction.normal, inputs)
                                                    : enter(state, friction.normal, inputs, part);
  }
}

double Network::spring_force(const NetworkState& state, int spring) const noexcept {
  const auto& s = model_->springs[index(spring)];
  double speed = speed_between(state, s.upper, s.lower);
  if (s.axes > 1) {
    speed = 0.0;
    for (int a = 0; a < s.axes; ++a)
      speed += s.along[index(a)] * speed_between(state, s.upper + a, s.lower + a);
  }
  return s.stiffness * extension(state, spring) + s.damping * speed;
}

double Network::indentation(const NetworkState& state, int contact) const noexcept {
  return std::max(0.0, tactus::indentation(state.position, model_->contacts[index(contact)]));
}

double Network::contact_force(const NetworkState& state, int contact) const noexcept {
  const auto& c = model_->contacts[index(contact)];
  const double n = tactus::indentation(state.position, c);
  if (n <= 0.0) return 0.0;
  const double speed = speed_between(state, c.lower, c.upper);
  return std::max(0.0, c.law.force(n) * (1.0 + state.loss[index(contact)] * speed));
}

double Network::applied_force(const NetworkState& state, int force) const noexcept {
  const auto& input = model_->forces[index(force)].input;
  return input.low_pass >= 0 ? state.low_pass[index(input.low_pass)].value : before(state, input);
}

double Network::bond_force(const NetworkState& state, int bond) const noexcept {
  if (state.slipped[index(bond)] != 0.0) return 0.0;
  const auto& b = model_->bonds[index(bond)];
  const double n = bond_distance(state, bond);
  if (b.axes > 1) {
    const auto along = unit(apart(state.position, b));
    double speed = 0.0;
    for (int a = 0; a < b.axes; ++a)
      speed += along[index(a)] * speed_between(state, b.lower + a, b.upper + a);
    return b.law->force(n) + b.damping * speed;
  }
  const double law = b.law->linear()
                         ? b.law->root_slope(n) * state.root[model_->contacts.size() + index(bond)]
                         : b.law->force(n);
  return law + b.damping * speed_between(state, b.lower, b.upper);
}

}  // namespace tactus
