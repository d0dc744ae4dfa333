#include <algorithm>
#include <cmath>

#include "engine/core/index.h"
#include "engine/physics/couplings/couplings.h"
#include "engine/physics/numbers.h"
#include "engine/physics/solvers/link_operator.h"
#include "engine/physics/solvers/network_solver.h"
#include "engine/physics/solvers/sparse_solver.h"

namespace tactus {
namespace {

// Fewer masses are stepped faster one by one.
constexpr int kShortestRow = 16;

double contact_energy(const ContactLaw& law, double n) { return n > 0.0 ? law.energy(n) : 0.0; }

class CentredSolver final : public NetworkSolver {
 public:
  CentredSolver(const NetworkModel& model, Solver kind) : model_(model), kind_(kind) {}
  Status make() {
    // Too stiff, or NaN.
    if (kind_ == Solver::Passive)
      averaged_ = !(model_.stiffest(1.0, 0.0) * model_.k * model_.k <= 0.99 * 4.0);
    if (kind_ == Solver::Implicit) averaged_ = true;
    auto links = model_.links();
    links_ = LinkOperator(std::move(links.entries), links.constant);
    Status status;
    if (factored()) status = factor();
    if (status) status = slow_start();
    if (status && kind_ == Solver::Explicit && model_.masses >= kShortestRow && model_.frictions.empty())
      arrange_links(std::move(links.constant));
    if (status) status = couple();
    return status;
  }

  Cost cost() const override {
    const double links = static_cast<double>(links_.entries().size());
    const double contact = kind_ == Solver::Explicit ? 15.0 : kind_ == Solver::Passive ? 40.0 : 150.0;
    const auto solve = factored() ? static_cast<double>(solver_.multiplications()) : 0.0;
    const double couplings = 4.0 * static_cast<double>(couplings_.count());
    return {2.0 * links + 2.0 * model_.masses + solve + 12.0 * static_cast<double>(model_.coils.size()) +
                couplings,
            contact + (factored() ? model_.masses : 0.0)};
  }

  /// Second order in k, exact for a constant acceleration: (3q - 4q- + q--) / 2k.
  double velocity(const NetworkState& state, int slot) const noexcept override {
    return (1.5 * state.moved[index(slot)] - 0.5 * state.moved_before[index(slot)]) / model_.k;
  }

  /// From half a step ago to now: exact for the voltage that was held last, at a constant speed.
  double current(const NetworkState& state, int coil) const noexcept override {
    const auto& c = model_.coils[index(coil)];
    const int signal = c.voltage.signal;
    const double voltage = signal < 0 ? 0.0 : state.held[index(signal)];
    const double speed = velocity(state, c.on) - velocity(state, c.against);
    const double final_current = (voltage - c.force_factor * speed) / c.resistance;
    return final_current + (state.current[index(coil)] - final_current) * c.half_step_decay;
  }

  /// Positions before the start, from position, velocity and acceleration at the start: consistent to second
  /// order. Inputs count as 0 before the start, which makes the first step exact for any first input. Solvers
  /// that solve for A bend these forces by A^-1 in place of k^2/m, which is the trapezoidal rule's own step
  /// back: what is too stiff for the rate swings as far as it was drawn, and no farther.
  void start(NetworkState& state) const noexcept override {
    for (std::size_t i = 0; i < start_velocity_.size(); ++i) state.moved[i] = model_.k * start_velocity_[i];
    state.active.clear();
    const auto add = [&](std::size_t coupling, double stiffness, double force) {
      state.active.push_back(
          {.coupling = static_cast<int>(coupling), .force = softened(coupling, stiffness, force)});
    };
    for (std::size_t c = 0; c < model_.contacts.size(); ++c) {
      const auto& contact = model_.contacts[c];
      const double motion = between(state.moved, contact), n = indentation(state.position, contact);
      start_loss(model_, state, c, motion);
      if (n <= 0.0) continue;
      const double rate = 1.0 + state.loss[c] * motion / model_.k;
      add(c, contact.law.stiffness(n), std::max(0.0, contact.law.force(n) * rate));
    }
    slow(state);
    links_.apply(state.position.data(), state.moved_before.data(), state.change.data());
    for (const auto& [on, input] : model_.forces)
      if (input.low_pass >= 0 && model_.is_mass(on))
        state.change[index(on)] += state.low_pass[index(input.low_pass)].value;
    for (std::size_t b = 0; b < model_.bonds.size(); ++b) {
      const auto& bond = model_.bonds[b];
      const double n = between(state.position, bond), speed = between(state.moved, bond) / model_.k;
      if (state.slipped[b] == 0.0)
        add(model_.contacts.size() + b, std::max(0.0, bond.law->stiffness(n)),
            bond.law->force(n) + bond.damping * speed);
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
    if (kind_ == Solver::Passive) store_pressed(state);
  }

  void store_energy(NetworkState& state) const noexcept override { couplings_.store_energy(state); }

  void step(NetworkState& state) const noexcept override {
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
    model_.send_waves(state, [&](int slot) { return travel(state, slot); });
    advance(state);
  }

  double energy(const NetworkState& state) const noexcept override {
    double sum = 0.0;
    for (std::size_t i = 0; i < model_.mass.size(); ++i)
      sum += 0.5 * model_.mass[i] * square(state.moved[i] / model_.k);
    for (const auto& s : model_.springs) {
      const double now = extension(state.position, s);
      const double before = now - (state.moved[index(s.upper)] - state.moved[index(s.lower)]);
      sum += 0.5 * s.stiffness * (averaged_ ? square(0.5 * (now + before)) : now * before);
    }
    for (std::size_t c = 0; c < model_.contacts.size(); ++c) {
      const auto& contact = model_.contacts[c];
      const double n = indentation(state.position, contact), now = contact_energy(contact.law, n);
      if (kind_ == Solver::Passive)
        sum += 0.5 * square(state.root[c]);
      else if (kind_ == Solver::Implicit)
        sum += 0.5 * (now + contact_energy(contact.law, n - between(state.moved, contact)));
      else
        sum += now;
    }
    for (std::size_t p = model_.contacts.size(); p < state.root.size(); ++p)
      sum += 0.5 * square(state.root[p]);
    return model_.with_inductances(sum, state);
  }
  bool centred() const override { return true; }
  bool springs_averaged() const override { return averaged_; }

 private:
  /// What the change of a driven point does to a mass: the columns of A outside the masses.
  struct DrivenColumn {
    int mass, driven;
    double a;
  };

  bool factored() const { return kind_ != Solver::Explicit; }

  /// Of M/k^2, of springs so much, and of dampers as A has them or nothing.
  Result<SparseSolver> solver_of(double k_share, bool dampers) const {
    std::vector<Eigen::Triplet<double>> entries;
    for (int i = 0; i < model_.masses; ++i) entries.emplace_back(i, i, 1.0 / model_.scale[index(i)]);
    for (const auto& e : links_.entries()) {
      const double a = k_share * e.k + (dampers ? 0.5 * e.b + e.inertia : 0.0);
      if (a != 0.0 && e.column < model_.masses) entries.emplace_back(e.row, e.column, a);
    }
    Eigen::SparseMatrix<double> matrix(model_.masses, model_.masses);
    matrix.setFromTriplets(entries.begin(), entries.end());
    SparseSolver solver(matrix);
    if (solver.valid()) return solver;
    return fail(Errc::OutOfRange, {},
                "the values of its masses, springs and dampers differ too much for the solver",
                "look for a value that is much too large or too small");
  }

  Status factor() {
    const double k_share = averaged_ ? 0.25 : 0.0;
    for (const auto& e : links_.entries()) {
      const double a = k_share * e.k + 0.5 * e.b + e.inertia;
      if (a != 0.0 && e.column >= model_.masses) driven_columns_.push_back({e.row, e.column, a});
    }
    auto solver = solver_of(k_share, true);
    if (!solver) return tl::unexpected(solver.error());
    solver_ = std::move(*solver);
    return {};
  }

  /// The trapezoidal rule's mean velocity of the step before the start,
  ///   v = (M/k^2 + K/4)^-1 (M/k^2) v_0,
  /// where springs are averaged: a mode of w k above 1 would else start with 1 + (w k / 2)^2 times its
  /// energy.
  Status slow_start() {
    start_velocity_ = model_.start_velocity;
    const auto moves = [](double v) { return v != 0.0; };
    if (!averaged_ || std::none_of(start_velocity_.begin(), start_velocity_.end(), moves)) return {};
    const auto springs = solver_of(0.25, false);
    if (!springs) return tl::unexpected(springs.error());
    std::vector<double> work(model_.mass.size());
    for (std::size_t i = 0; i < model_.mass.size(); ++i) start_velocity_[i] /= model_.scale[i];
    springs->solve({start_velocity_.data(), model_.mass.size()}, work);
    return {};
  }

  Status couple() {
    using Method = Couplings::Method;
    const auto method = kind_ == Solver::Explicit  ? Method::Explicit
                        : kind_ == Solver::Passive ? Method::Centred
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

  void arrange_links(std::vector<double> constant) {
    std::vector<LinkOperator::Entry> jumps;
    row_ = MassRow(links_.entries(), model_.scale, jumps);
    std::vector<bool> pushed(model_.mass.size(), !jumps.empty());
    for (std::size_t i = 0; i < pushed.size(); ++i)
      if (constant[i] != 0.0) pushed[i] = true;
    const auto push = [&](int slot) {
      if (model_.is_mass(slot)) pushed[index(slot)] = true;
    };
    for (const auto& force : model_.forces) push(force.on);
    for (const auto& port : model_.ports) push(port.on);
    for (const auto& contact : model_.contacts) push(contact.lower), push(contact.upper);
    for (const auto& bond : model_.bonds) push(bond.lower), push(bond.upper);
    for (const auto& coil : model_.coils) push(coil.on), push(coil.against);
    row_.let_push(pushed);
    in_row_ = true;
    constant_ = constant;
    jumps_ = LinkOperator(std::move(jumps), std::move(constant));
  }

  /// What dampers see at the start, into `moved_before`: A^-1 (M/k^2) of the motion, so that those that stop
  /// a mass within a step give it nothing.
  void slow(NetworkState& state) const noexcept {
    std::copy(state.moved.begin(), state.moved.end(), state.moved_before.begin());
    if (!factored()) return;
    const auto masses = model_.mass.size();
    for (std::size_t i = 0; i < masses; ++i) state.moved_before[i] /= model_.scale[i];
    solver_.solve({state.moved_before.data(), masses}, state.work);
  }

  void bend(NetworkState& state) const noexcept {
    const auto masses = model_.mass.size();
    if (!factored()) return multiply(model_.scale.data(), masses, state.change.data());
    solver_.solve({state.change.data(), masses}, state.work);
  }

  /// The root psi of a contact that is pressed at the start. Its energy, together with the kinetic energy
  /// that the first half step gives to the masses, is the energy stored at the start: with F its force in the
  /// first step, W the mobility of its points,
  ///   psi^2 / 2 = phi(n_0) - F k v_0 / 2 - F^2 W / 8.
  void store_pressed(NetworkState& state) const noexcept {
    for (std::size_t c = 0; c < model_.contacts.size(); ++c) {
      const auto& contact = model_.contacts[c];
      const double n = indentation(state.position, contact), w = couplings_.mutual(c, c);
      if (n <= 0.0) continue;
      const double motion = model_.k * between(start_velocity_, contact);
      const double force = softened(c, contact.law.stiffness(n), contact.law.force(n));
      const double stored = contact.law.energy(n) - 0.5 * force * motion - 0.125 * force * force * w;
      state.root[c] = std::sqrt(2.0 * std::max(0.0, stored));
    }
  }

  /// What is left of a force whose own stiffness the step averages, as A averages that of the springs.
  double softened(std::size_t coupling, double stiffness, double force) const noexcept {
    return factored() ? force / (1.0 + 0.25 * couplings_.mutual(coupling, coupling) * stiffness) : force;
  }

  /// The forces of all links; of a row of masses, those that `MassRow` does not include.
  void start_forces(NetworkState& state) const noexcept {
    if (in_row_ && jumps_.entries().empty())
      row_.fill(constant_.data(), state.change.data());
    else
      (in_row_ ? jumps_ : links_).apply(state.position.data(), state.moved.data(), state.change.data());
  }

  void move_driven(NetworkState& state) const noexcept {
    for (std::size_t i = 0; i < model_.motions.size(); ++i) {
      const auto slot = index(model_.motions[i].on);
      state.change[slot] = state.next[i] - state.position[slot] - state.moved[slot];
    }
    for (const auto& c : driven_columns_) state.change[index(c.mass)] -= c.a * state.change[index(c.driven)];
  }

  void add_force(NetworkState& state, int slot, double force) const noexcept {
    if (model_.is_mass(slot)) state.change[index(slot)] += force;
  }

  void add_applied(NetworkState& state) const noexcept {
    for (std::size_t i = 0; i < model_.forces.size(); ++i)
      add_force(state, model_.forces[i].on, state.force[i]);
    for (std::size_t i = 0; i < model_.ports.size(); ++i)
      add_force(state, model_.ports[i].on, 2.0 * state.wave[i]);
  }

  /// The part of a coil's force that is there without motion; what motion adds is in the link operator.
  void add_coils(NetworkState& state) const noexcept {
    for (std::size_t i = 0; i < model_.coils.size(); ++i) {
      const auto& coil = model_.coils[i];
      state.mean_current[i] = (state.voltage[i] + coil.memory * state.current[i]) / coil.impedance;
      const double force = coil.force_factor * state.mean_current[i];
      add_force(state, coil.on, force);
      add_force(state, coil.against, -force);
    }
  }

  /// The couplings' forces on top of the others, where A is not solved for any more.
  void push(NetworkState& state) const noexcept {
    couplings_.push_all(state, [&](int slot, double force) { add_force(state, slot, force); });
  }

  double travel(const NetworkState& state, int slot) const noexcept {
    const double centre = factored() ? 0.5 : 0.0;
    return state.moved[index(slot)] + centre * state.change[index(slot)];
  }

  void step_currents(NetworkState& state) const noexcept {
    for (std::size_t i = 0; i < model_.coils.size(); ++i) {
      const auto& coil = model_.coils[i];
      const double motion = travel(state, coil.on) - travel(state, coil.against);
      state.mean_current[i] -= coil.force_factor * motion / (model_.k * coil.impedance);
      state.current[i] = 2.0 * state.mean_current[i] - state.current[i];
    }
  }

  /// u+ = u + e, q+ = q + u+, where the explicit solver's e is still k^2/m away.
  void advance(NetworkState& state) const noexcept {
    const auto masses = model_.mass.size();
    double *q = state.position.data(), *u = state.moved.data(), *e = state.change.data();
    double* u_next = state.moved_before.data();
    if (in_row_)
      row_.step(q, u, u_next, e);
    else if (!factored())
      multiply(model_.scale.data(), masses, e);
    const auto first = in_row_ ? masses : 0;
    const auto go = [=]<class Vector>(std::size_t i) {
      const Vector moving = load<Vector>(u + first + i) + load<Vector>(e + first + i);
      store(moving, u_next + first + i);
      store(load<Vector>(q + first + i) + moving, q + first + i);
    };
    for_all(masses + model_.motions.size() - first, go);
    state.moved.swap(state.moved_before);
  }

  const NetworkModel& model_;
  Solver kind_;
  bool averaged_ = false;
  LinkOperator links_;
  // Of many masses and the explicit solver: links between neighbours, and those that jump or are driven.
  bool in_row_ = false;
  std::vector<double> constant_;
  MassRow row_;
  LinkOperator jumps_;
  std::vector<DrivenColumn> driven_columns_;
  SparseSolver solver_;
  std::vector<double> start_velocity_;  ///< as the first step sees it
  Couplings couplings_;
};

}  // namespace

Result<std::unique_ptr<NetworkSolver>> make_centred_solver(const NetworkModel& model, Solver kind) {
  auto solver = std::make_unique<CentredSolver>(model, kind);
  if (auto status = solver->make(); !status) return tl::unexpected(status.error());
  return solver;
}

}  // namespace tactus
