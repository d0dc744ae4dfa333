#include "engine/physics/solvers/centred_solver.h"

#include <algorithm>
#include <cmath>

#include "engine/core/index.h"
#include "engine/physics/numbers.h"
#include "engine/physics/solvers/vectorised.h"

namespace tactus {
namespace {

// Fewer masses are stepped faster one by one.
constexpr int kShortestRow = 16;

/// The energy of a spring between two instants, in the form that each way of stepping it conserves.
double spring_energy(double stiffness, double extension, double before, bool averaged) {
  return 0.5 * stiffness * (averaged ? square(0.5 * (extension + before)) : extension * before);
}

double contact_energy(const ContactLaw& law, double n) { return n > 0.0 ? law.energy(n) : 0.0; }

}  // namespace

Result<std::unique_ptr<NetworkSolver>> CentredSolver::make(const NetworkModel& model, Kind kind) {
  std::unique_ptr<CentredSolver> solver(new CentredSolver(model, kind));
  // Too stiff, or NaN.
  if (kind == Kind::Passive)
    solver->averaged_ = !(model.stiffest(1.0, 0.0) * model.k * model.k <= 0.99 * 4.0);
  if (kind == Kind::Implicit) solver->averaged_ = true;
  auto links = model.links();
  solver->links_ = LinkOperator(std::move(links.entries), links.constant);
  if (solver->factored())
    if (auto status = solver->factor(); !status) return tl::unexpected(status.error());
  if (auto status = solver->slow_start(); !status) return tl::unexpected(status.error());
  if (kind == Kind::Explicit && model.masses >= kShortestRow && model.frictions.empty())
    solver->line_up(std::move(links.constant));
  if (auto status = solver->couple(); !status) return tl::unexpected(status.error());
  return solver;
}

/// Of M/k^2 and of the links so much.
Result<SparseSolver> CentredSolver::solver_of(double k_share, double b_share) const {
  std::vector<Eigen::Triplet<double>> entries;
  for (int i = 0; i < model_.masses; ++i) entries.emplace_back(i, i, 1.0 / model_.scale[index(i)]);
  for (const auto& e : links_.entries()) {
    const double a = k_share * e.k + b_share * e.b;
    if (a != 0.0 && e.column < model_.masses) entries.emplace_back(e.row, e.column, a);
  }
  Eigen::SparseMatrix<double> matrix(model_.masses, model_.masses);
  matrix.setFromTriplets(entries.begin(), entries.end());
  SparseSolver solver(matrix);
  if (solver.valid()) return solver;
  return fail(Errc::OutOfRange, {}, "its masses, springs and dampers are too far apart for the solver",
              "look for a number that is much too large or too small");
}

Status CentredSolver::factor() {
  const double k_share = averaged_ ? 0.25 : 0.0;
  for (const auto& e : links_.entries()) {
    const double a = k_share * e.k + 0.5 * e.b;
    if (a != 0.0 && e.column >= model_.masses) driven_columns_.push_back({e.row, e.column, a});
  }
  auto solver = solver_of(k_share, 0.5);
  if (!solver) return tl::unexpected(solver.error());
  solver_ = std::move(*solver);
  return {};
}

/// The trapezoidal rule's mean velocity of the step before the start,
///   v = (M/k^2 + K/4)^-1 (M/k^2) v_0,
/// where springs are averaged: a mode of w k above 1 would else start with 1 + (w k / 2)^2 times its energy.
Status CentredSolver::slow_start() {
  start_velocity_ = model_.start_velocity;
  const auto moves = [](double v) { return v != 0.0; };
  if (!averaged_ || std::none_of(start_velocity_.begin(), start_velocity_.end(), moves)) return {};
  const auto springs = solver_of(0.25, 0.0);
  if (!springs) return tl::unexpected(springs.error());
  std::vector<double> work(model_.mass.size());
  for (std::size_t i = 0; i < model_.mass.size(); ++i) start_velocity_[i] /= model_.scale[i];
  springs->solve({start_velocity_.data(), model_.mass.size()}, work);
  return {};
}

Status CentredSolver::couple() {
  using Method = Couplings::Method;
  const auto method = kind_ == Kind::Explicit  ? Method::Explicit
                      : kind_ == Kind::Passive ? Method::Centred
                                               : Method::Gradient;
  std::vector<double> work(model_.mass.size());
  auto made = Couplings::make(model_, method, [&](std::span<double> column) {
    if (factored()) return solver_.solve(column, work);
    for (std::size_t i = 0; i < column.size(); ++i) column[i] *= model_.scale[i];
  });
  if (!made) return tl::unexpected(made.error());
  couplings_ = std::move(*made);
  return {};
}

void CentredSolver::line_up(std::vector<double> constant) {
  std::vector<LinkOperator::Entry> jumps;
  row_ = MassRow(links_.entries(), model_.scale, jumps);
  std::vector<bool> pushed(model_.mass.size(), !jumps.empty());
  for (std::size_t i = 0; i < pushed.size(); ++i)
    if (constant[i] != 0.0) pushed[i] = true;
  const auto push = [&](int slot) {
    if (model_.is_mass(slot)) pushed[index(slot)] = true;
  };
  for (const auto& force : model_.forces) push(force.slot);
  for (const auto& port : model_.ports) push(port.wave.slot);
  for (const auto& contact : model_.contacts) push(contact.lower), push(contact.upper);
  for (const auto& bond : model_.bonds) push(bond.lower), push(bond.upper);
  for (const auto& coil : model_.coils) push(coil.on), push(coil.against);
  row_.let_push(pushed);
  in_row_ = true;
  constant_ = constant;
  jumps_ = LinkOperator(std::move(jumps), std::move(constant));
}

NetworkSolver::Cost CentredSolver::cost() const {
  const double links = static_cast<double>(links_.entries().size());
  const double contact = kind_ == Kind::Explicit ? 15.0 : kind_ == Kind::Passive ? 40.0 : 150.0;
  const auto solve = factored() ? static_cast<double>(solver_.multiplications()) : 0.0;
  const double couplings = 4.0 * static_cast<double>(couplings_.count());
  return {
      2.0 * links + 2.0 * model_.masses + solve + 12.0 * static_cast<double>(model_.coils.size()) + couplings,
      contact + (factored() ? model_.masses : 0.0)};
}

double CentredSolver::velocity(const NetworkState& state, int slot) const noexcept {
  return (1.5 * state.moved[index(slot)] - 0.5 * state.moved_before[index(slot)]) / model_.k;
}

double CentredSolver::current(const NetworkState& state, int coil) const noexcept {
  const auto& c = model_.coils[index(coil)];
  const int signal = c.voltage.input.signal;
  const double voltage = signal < 0 ? 0.0 : state.held[index(signal)];
  const double speed = velocity(state, c.on) - velocity(state, c.against);
  const double final_current = (voltage - c.force_factor * speed) / c.resistance;
  return final_current + (state.current[index(coil)] - final_current) * c.half_step_decay;
}

/// Positions before the start, from position, velocity and acceleration at the start: consistent to second
/// order. Inputs count as 0 before the start, which makes the first step exact for any first input. Solvers
/// that solve for A bend these forces by A^-1 in place of k^2/m, which is the trapezoidal rule's own step
/// back: what is too stiff for the rate swings as far as it was drawn, and no farther.
void CentredSolver::start(NetworkState& state) const noexcept {
  for (std::size_t i = 0; i < start_velocity_.size(); ++i) state.moved[i] = model_.k * start_velocity_[i];
  state.active.clear();
  for (std::size_t c = 0; c < model_.contacts.size(); ++c) {
    const auto& contact = model_.contacts[c];
    const auto lower = index(contact.lower), upper = index(contact.upper);
    const double motion = state.moved[lower] - state.moved[upper];
    const double n = state.position[lower] - state.position[upper] + contact.offset;
    state.loss[c] = contact.loss;
    if (n <= 0.0) continue;
    start_contact(model_, state, c, n, std::max(n, motion));
    const double rate = 1.0 + state.loss[c] * motion / model_.k;
    state.active.push_back(
        {.coupling = static_cast<int>(c),
         .force = softened(c, contact.law.stiffness(n), std::max(0.0, contact.law.force(n) * rate))});
  }
  slow(state);
  links_.apply(state.position.data(), state.moved_before.data(), state.change.data());
  for (const auto& force : model_.forces)
    if (force.low_pass >= 0 && model_.is_mass(force.slot))
      state.change[index(force.slot)] += state.low_pass[index(force.low_pass)].value;
  for (std::size_t b = 0; b < model_.bonds.size(); ++b) {
    const auto& bond = model_.bonds[b];
    const auto lower = index(bond.lower), upper = index(bond.upper), c = model_.contacts.size() + b;
    const double n = state.position[lower] - state.position[upper];
    const double speed = (state.moved[lower] - state.moved[upper]) / model_.k;
    if (state.slipped[b] == 0.0)
      state.active.push_back({.coupling = static_cast<int>(c),
                              .force = softened(c, std::max(0.0, bond.law->stiffness(n)),
                                                bond.law->force(n) + bond.damping * speed)});
  }
  push(state);
  bend(state);
  for (std::size_t i = 0; i < model_.mass.size(); ++i) {
    const double straight = state.moved[i];
    state.moved[i] = straight - 0.5 * state.change[i];
    state.moved_before[i] = straight - 1.5 * state.change[i];
  }
  state.active.clear();
  store_energy(state);
}

/// What dampers see at the start, into `moved_before`: A^-1 (M/k^2) of the motion, so that those that stop a
/// mass within a step give it nothing.
void CentredSolver::slow(NetworkState& state) const noexcept {
  std::copy(state.moved.begin(), state.moved.end(), state.moved_before.begin());
  if (!factored()) return;
  const auto masses = model_.mass.size();
  for (std::size_t i = 0; i < masses; ++i) state.moved_before[i] /= model_.scale[i];
  solver_.solve({state.moved_before.data(), masses}, state.work);
}

void CentredSolver::bend(NetworkState& state) const noexcept {
  const auto masses = model_.mass.size();
  if (!factored()) return multiply(model_.scale.data(), masses, state.change.data());
  solver_.solve({state.change.data(), masses}, state.work);
}

/// What is left of a force whose own stiffness the step averages, as A averages that of the springs.
double CentredSolver::softened(std::size_t coupling, double stiffness, double force) const noexcept {
  return factored() ? force / (1.0 + 0.25 * couplings_.mutual(coupling, coupling) * stiffness) : force;
}

void CentredSolver::store_energy(NetworkState& state) const noexcept { couplings_.store_energy(state); }

void CentredSolver::step(NetworkState& state) const noexcept {
  start_forces(state);
  if (!model_.motions.empty()) move_driven(state);
  add_applied(state);
  if (!model_.coils.empty()) add_coils(state);
  if (factored()) solver_.solve({state.change.data(), model_.mass.size()}, state.work);
  if (!couplings_.empty()) {
    couplings_.solve(state);
    if (factored())
      couplings_.move(state);
    else
      push(state);
    couplings_.finish(state);
  }
  if (!model_.coils.empty()) step_currents(state);
  if (!model_.ports.empty()) send_waves(state);
  if (state.audit) audit(state);
  advance(state);
}

/// The forces of all links; of a row of masses, those that `MassRow` does not include.
void CentredSolver::start_forces(NetworkState& state) const noexcept {
  if (in_row_ && jumps_.entries().empty())
    row_.fill(constant_.data(), state.change.data());
  else
    (in_row_ ? jumps_ : links_).apply(state.position.data(), state.moved.data(), state.change.data());
}

void CentredSolver::move_driven(NetworkState& state) const noexcept {
  for (std::size_t i = 0; i < model_.motions.size(); ++i) {
    const auto slot = index(model_.motions[i].slot);
    state.change[slot] = state.next[i] - state.position[slot] - state.moved[slot];
  }
  for (const auto& c : driven_columns_) state.change[index(c.mass)] -= c.a * state.change[index(c.driven)];
}

void CentredSolver::add_applied(NetworkState& state) const noexcept {
  for (std::size_t i = 0; i < model_.forces.size(); ++i) {
    const int slot = model_.forces[i].slot;
    if (model_.is_mass(slot)) state.change[index(slot)] += state.force[i];
  }
  for (std::size_t i = 0; i < model_.ports.size(); ++i) {
    const int slot = model_.ports[i].wave.slot;
    if (model_.is_mass(slot)) state.change[index(slot)] += 2.0 * state.wave[i];
  }
}

/// The part of a coil's force that is there without motion; what motion adds is in the link operator.
void CentredSolver::add_coils(NetworkState& state) const noexcept {
  for (std::size_t i = 0; i < model_.coils.size(); ++i) {
    const auto& coil = model_.coils[i];
    state.mean_current[i] = (state.voltage[i] + coil.memory * state.current[i]) / coil.impedance;
    const double force = coil.force_factor * state.mean_current[i];
    if (model_.is_mass(coil.on)) state.change[index(coil.on)] += force;
    if (model_.is_mass(coil.against)) state.change[index(coil.against)] -= force;
  }
}

/// The couplings' forces on top of the others, where A is not solved for any more.
void CentredSolver::push(NetworkState& state) const noexcept {
  couplings_.push_all(state, [&](int slot, double force) {
    if (model_.is_mass(slot)) state.change[index(slot)] += force;
  });
}

double CentredSolver::travel(const NetworkState& state, int slot) const noexcept {
  const double centre = factored() ? 0.5 : 0.0;
  return state.moved[index(slot)] + centre * state.change[index(slot)];
}

void CentredSolver::step_currents(NetworkState& state) const noexcept {
  for (std::size_t i = 0; i < model_.coils.size(); ++i) {
    const auto& coil = model_.coils[i];
    const double motion = travel(state, coil.on) - travel(state, coil.against);
    state.mean_current[i] -= coil.force_factor * motion / (model_.k * coil.impedance);
    state.current[i] = 2.0 * state.mean_current[i] - state.current[i];
  }
}

void CentredSolver::send_waves(NetworkState& state) const noexcept {
  for (std::size_t i = 0; i < model_.ports.size(); ++i) {
    const auto& port = model_.ports[i];
    state.wave_back[i] += state.wave[i] - port.impedance * travel(state, port.wave.slot) / model_.k;
  }
}

/// u+ = u + e, q+ = q + u+, where the explicit solver's e is still k^2/m away.
void CentredSolver::advance(NetworkState& state) const noexcept {
  const auto masses = model_.mass.size();
  double *q = state.position.data(), *u = state.moved.data(), *e = state.change.data();
  double* u_next = state.moved_before.data();
  if (in_row_)
    row_.step(q, u, u_next, e);
  else if (!factored())
    multiply(model_.scale.data(), masses, e);
  const auto first = in_row_ ? masses : 0;
  const auto go = [=]<class Wide>(std::size_t i) {
    const Wide moving = load<Wide>(u + first + i) + load<Wide>(e + first + i);
    store(moving, u_next + first + i);
    store(load<Wide>(q + first + i) + moving, q + first + i);
  };
  for_all(masses + model_.motions.size() - first, go);
  state.moved.swap(state.moved_before);
}

double CentredSolver::energy(const NetworkState& state) const noexcept {
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
void CentredSolver::audit(NetworkState& state) const noexcept {
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
  for (const auto& link : state.active) state.dissipated += lost(state, link);
  for (std::size_t f = 0; f < couplings_.frictions(); ++f)
    state.dissipated +=
        0.5 * state.friction_force[f] * couplings_.motion(state, couplings_.first_friction() + f);
  for (std::size_t i = 0; i < model_.coils.size(); ++i) {
    const auto& coil = model_.coils[i];
    const double force = coil.force_factor * state.mean_current[i];
    state.supplied += model_.k * state.voltage[i] * state.mean_current[i];
    state.supplied += force * (by_hand(coil.against) - by_hand(coil.on));
    state.dissipated += model_.k * coil.resistance * square(state.mean_current[i]);
  }
}

/// What a contact or a bond dissipates.
double CentredSolver::lost(const NetworkState& state, const ActiveCoupling& link) const noexcept {
  const auto c = index(link.coupling);
  if (kind_ != Kind::Implicit || c >= model_.contacts.size())
    return 0.5 * (link.resistance - 0.25 * square(link.slope)) * square(link.motion);
  const auto& contact = model_.contacts[c];
  const auto lower = index(contact.lower), upper = index(contact.upper);
  const double n = state.position[lower] - state.position[upper] + contact.offset;
  const double before = n - (state.moved[lower] - state.moved[upper]);
  const double stored =
      contact_energy(contact.law, before + link.motion) - contact_energy(contact.law, before);
  return 0.5 * (link.force * link.motion - stored);
}

}  // namespace tactus
