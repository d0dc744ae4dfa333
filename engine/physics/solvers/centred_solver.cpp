#include <algorithm>
#include <cmath>

#include "engine/core/index.h"
#include "engine/physics/numbers.h"
#include "engine/physics/solvers/network_solver.h"
#include "engine/physics/solvers/solver_tables.h"

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
    if (status) status = bend_bonds();
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
    for (std::size_t c = 0; c < model_.contacts.size(); ++c) {
      const double motion = between(state.moved, model_.contacts[c]);
      start_loss(model_, state, c, motion);
      const double force = first_push(state, c);
      if (force == 0.0) continue;
      state.active.push_back({.coupling = static_cast<int>(c), .force = with_loss(state, c, force, motion)});
    }
    slow(state);
    links_.apply(state.position.data(), state.moved_before.data(), state.change.data());
    for (const auto& [on, input] : model_.forces)
      if (input.low_pass >= 0 && model_.is_mass(on))
        state.change[index(on)] += state.low_pass[index(input.low_pass)].value;
    for (std::size_t b = 0; b < model_.bonds.size(); ++b) {
      const auto& bond = model_.bonds[b];
      const double n = stretch(state.position, bond);
      const double speed =
          (bond.axes == 1 ? between(state.moved_before, bond)
                          : dot(unit(apart(state.position, bond)), apart(state.moved_before, bond))) /
          model_.k;
      if (state.slipped[b] == 0.0)
        state.active.push_back({.coupling = static_cast<int>(model_.contacts.size() + b),
                                .force = bond.law->force(n) + bond.damping * speed});
    }
    couplings_.find_lines(state);
    push(state);
    bend(state);
    for (std::size_t i = 0; i < model_.mass.size(); ++i) {
      const double straight = state.moved[i];
      state.moved[i] = straight - 0.5 * state.change[i];
      state.moved_before[i] = straight - 1.5 * state.change[i];
    }
    state.active.clear();
    store_energy(state);
    if (factored()) store_pressed(state);
    if (!model_.frictions.empty()) lend(state);
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
      const double before = now - span(state.moved, s);
      sum += 0.5 * s.stiffness * (averaged_ ? square(0.5 * (now + before)) : now * before);
    }
    for (std::size_t c = 0; c < model_.contacts.size(); ++c) {
      const auto& contact = model_.contacts[c];
      const double n = indentation(state.position, contact), now = contact_energy(contact.law, n);
      if (kind_ == Solver::Passive)
        sum += 0.5 * square(state.root[c]);
      else if (kind_ == Solver::Implicit)
        sum += 0.5 * (contact_energy(contact.law, couplings_.depth(state, c)) +
                      contact_energy(contact.law, couplings_.depth_before(state, c)));
      else
        sum += now;
    }
    for (std::size_t p = model_.contacts.size(); p < state.root.size(); ++p)
      sum += 0.5 * square(state.root[p]);
    return model_.with_inductances(sum, state);
  }
  bool centred() const override { return true; }
  bool springs_averaged() const override { return averaged_; }
  SolverTables tables() const override {
    return {.couplings = &couplings_,
            .averaged = averaged_,
            .links = &links_,
            .row = in_row_ ? &row_ : nullptr,
            .jumps = in_row_ ? &jumps_ : nullptr,
            .solver = factored() ? &solver_ : nullptr,
            .start_solver = factored() ? &start_solver() : nullptr,
            .driven = driven_columns_,
            .start_velocity = start_velocity_};
  }

 private:
  bool factored() const { return kind_ != Solver::Explicit; }

  /// Of M/k^2, of springs so much, of bonds a quarter or nothing, and of dampers as A has them or nothing.
  Result<SparseSolver> solver_of(double k_share, bool bonds, bool dampers) const {
    std::vector<Eigen::Triplet<double>> entries;
    for (int i = 0; i < model_.masses; ++i) entries.emplace_back(i, i, 1.0 / model_.scale[index(i)]);
    for (const auto& e : links_.entries()) {
      const double a = k_share * e.k + (dampers ? 0.5 * e.b + e.inertia : 0.0);
      if (a != 0.0 && e.column < model_.masses) entries.emplace_back(e.row, e.column, a);
    }
    if (bonds) add_bonds(entries, dampers);
    Eigen::SparseMatrix<double> matrix(model_.masses, model_.masses);
    matrix.setFromTriplets(entries.begin(), entries.end());
    SparseSolver solver(matrix);
    if (solver.valid()) return solver;
    return fail(Errc::OutOfRange, {},
                "the values of its masses, springs and dampers differ too much for the solver",
                "look for a value that is much too large or too small");
  }

  /// As they are at the start.
  void add_bonds(std::vector<Eigen::Triplet<double>>& entries, bool dampers) const {
    for (std::size_t b = 0; b < model_.bonds.size(); ++b) {
      const auto& bond = model_.bonds[b];
      if (bond.axes > 1) {
        add_line(entries, bond, dampers);
        continue;
      }
      const double n = between(model_.start_position, bond);
      if (std::abs(bond.law->force(n)) > bond.limit) continue;
      double a = 0.25 * std::max(0.0, bond.law->stiffness(n));
      if (dampers) a += 0.5 * bond.damping / model_.k + couplings_.inertia(b);
      for (const int row : {bond.lower, bond.upper})
        for (const int column : {bond.lower, bond.upper})
          if (model_.is_mass(row) && model_.is_mass(column))
            entries.emplace_back(row, column, row == column ? a : -a);
    }
  }

  /// Along the line the stiffness of the law, across it F / |r| where it pulls.
  void add_line(std::vector<Eigen::Triplet<double>>& entries, const Bond& bond, bool dampers) const {
    const auto r = apart(model_.start_position, bond);
    const auto along = unit(r);
    const double n = stretch(model_.start_position, bond), l = length(r);
    const double across = l > 0.0 ? 0.25 * std::max(0.0, bond.law->force(n) / l) : 0.0;
    double own = 0.25 * std::max(0.0, bond.law->stiffness(n));
    if (dampers) own += 0.5 * bond.damping / model_.k;
    for (int i = 0; i < bond.axes; ++i)
      for (int j = 0; j < bond.axes; ++j) {
        const double a = (own - across) * along[index(i)] * along[index(j)] + (i == j ? across : 0.0);
        for (const int row : {bond.lower, bond.upper})
          for (const int column : {bond.lower, bond.upper})
            if (a != 0.0 && model_.is_mass(row) && model_.is_mass(column))
              entries.emplace_back(row + i, column + j, row == column ? a : -a);
      }
  }

  Status factor() {
    const double k_share = averaged_ ? 0.25 : 0.0;
    for (const auto& e : links_.entries()) {
      const double a = k_share * e.k + 0.5 * e.b + e.inertia;
      if (a != 0.0 && e.column >= model_.masses) driven_columns_.push_back({e.row, e.column, a});
    }
    auto solver = solver_of(k_share, false, true);
    if (!solver) return tl::unexpected(solver.error());
    solver_ = std::move(*solver);
    return {};
  }

  /// The trapezoidal rule's mean velocity of the step before the start,
  ///   v = (M/k^2 + K/4)^-1 (M/k^2) v_0,
  /// where springs are averaged, and bonds: a mode of w k above 1 would else start with 1 + (w k / 2)^2 times
  /// its energy.
  Status slow_start() {
    start_velocity_ = model_.start_velocity;
    const auto moves = [](double v) { return v != 0.0; };
    if (!averages() || std::none_of(start_velocity_.begin(), start_velocity_.end(), moves)) return {};
    const auto springs = solver_of(averaged_ ? 0.25 : 0.0, true, false);
    if (!springs) return tl::unexpected(springs.error());
    std::vector<double> work(springs->workspace());
    for (std::size_t i = 0; i < model_.mass.size(); ++i) start_velocity_[i] /= model_.scale[i];
    springs->solve({start_velocity_.data(), model_.mass.size()}, work);
    return {};
  }

  bool averages() const { return averaged_ || (factored() && !model_.bonds.empty()); }

  /// A with the bonds, which are springs at the start.
  Status bend_bonds() {
    if (!factored() || model_.bonds.empty()) return {};
    auto solver = solver_of(averaged_ ? 0.25 : 0.0, true, true);
    if (!solver) return tl::unexpected(solver.error());
    start_solver_ = std::move(*solver);
    return {};
  }
  const SparseSolver& start_solver() const { return model_.bonds.empty() ? solver_ : start_solver_; }

  Status couple() {
    using Method = Couplings::Method;
    const auto method = kind_ == Solver::Explicit  ? Method::Explicit
                        : kind_ == Solver::Passive ? Method::Centred
                                                   : Method::Gradient;
    std::vector<double> work(solver_.workspace());
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
    start_solver().solve({state.moved_before.data(), masses}, state.work);
  }

  void bend(NetworkState& state) const noexcept {
    const auto masses = model_.mass.size();
    if (!factored()) return multiply(model_.scale.data(), masses, state.change.data());
    start_solver().solve({state.change.data(), masses}, state.work);
  }

  /// What the network holds at its start [J].
  double start_energy(const NetworkState& state) const noexcept {
    double sum = 0.0;
    for (std::size_t i = 0; i < model_.mass.size(); ++i)
      sum += 0.5 * model_.mass[i] * square(model_.start_velocity[i]);
    for (const auto& s : model_.springs) sum += 0.5 * s.stiffness * square(extension(state.position, s));
    for (const auto& contact : model_.contacts)
      sum += contact_energy(contact.law, indentation(state.position, contact));
    for (std::size_t b = 0; b < model_.bonds.size(); ++b)
      if (state.slipped[b] == 0.0)
        sum += model_.bonds[b].law->energy(stretch(state.position, model_.bonds[b]));
    return sum;
  }

  /// What the step before the start lacks of that, as its forces have not been slowed by friction, is all
  /// that frictions may give in the first step. They share it.
  void lend(NetworkState& state) const noexcept {
    const double lacking = std::max(0.0, start_energy(state) - energy(state));
    for (auto& friction : state.friction)
      friction.heat = lacking / (model_.k * static_cast<double>(model_.frictions.size()));
  }

  /// What the contacts hold half a step before the start. One that is open at the start holds nothing,
  /// wherever its points would have been. The energy of one that is pressed, together with the kinetic energy
  /// that the first half step gives to the masses, is the energy stored at the start: with F the forces in
  /// the first step, W the mobility of their points,
  ///   stored = phi(n_0) - F (k v_0 / 2 + W F / 8).
  void store_pressed(NetworkState& state) const noexcept {
    const auto contacts = model_.contacts.size();
    auto& force = state.right;
    for (std::size_t c = 0; c < contacts; ++c) force[c] = first_push(state, c);
    for (std::size_t c = 0; c < contacts; ++c) {
      const auto& contact = model_.contacts[c];
      double way = 0.5 * model_.k * between(start_velocity_, contact);
      for (std::size_t other = 0; other < contacts; ++other)
        way += 0.125 * couplings_.mutual(c, other) * force[other];
      const double n = indentation(state.position, contact);
      const double stored = force[c] == 0.0 ? 0.0 : std::max(0.0, contact.law.energy(n) - force[c] * way);
      state.root[c] = kind_ == Solver::Passive
                          ? std::sqrt(2.0 * stored)
                          : shallower(contact.law, n, n - between(state.moved, contact), stored);
    }
  }

  /// What to add to two depths for the mean of their energies to be no more than `energy`; <= 0.
  static double shallower(const ContactLaw& law, double one, double other, double energy) noexcept {
    const auto holds = [&](double by) {
      return 0.5 * (contact_energy(law, one + by) + contact_energy(law, other + by)) <= energy;
    };
    if (holds(0.0)) return 0.0;
    double low = -std::max(one, other), high = 0.0;
    for (int i = 0; i < 60; ++i) {
      const double middle = 0.5 * (low + high);
      (holds(middle) ? low : high) = middle;
    }
    return low;
  }

  /// What a contact pushes with in the first step: no more than makes it just closed half a step before.
  double first_push(const NetworkState& state, std::size_t c) const noexcept {
    const auto& contact = model_.contacts[c];
    const double n = indentation(state.position, contact);
    if (n <= 0.0) return 0.0;
    const double force = softened(c, contact.law.stiffness(n), contact.law.force(n));
    if (!factored()) return force;
    const double motion = model_.k * between(start_velocity_, contact), w = couplings_.mutual(c, c);
    const double all = 4.0 * contact.law.energy(n);
    return std::min(force, all / (motion + std::sqrt(square(motion) + 0.5 * w * all)));
  }

  /// A contact's force at the start with that of its loss, of a motion that the loss has slowed: as a damper
  /// z = F r in A is, by z k / 2m = W F r / 2k.
  double with_loss(const NetworkState& state, std::size_t c, double force, double motion) const noexcept {
    const double loss = state.loss[c] / model_.k;
    const double own = factored() ? 0.5 * couplings_.mutual(c, c) * force * loss : 0.0;
    return force * std::max(0.0, 1.0 + loss * motion / square(1.0 + own));
  }

  /// One contact, with what the others push by now: Newton's method from the free motion up to the zero of a
  /// concave function.
  void push_back_in_time(const NetworkState& state, ActiveCoupling& link) const noexcept {
    constexpr int kMostSteps = 60;
    const auto c = index(link.coupling);
    const auto& contact = model_.contacts[c];
    const double own = 0.5 * couplings_.mutual(c, c), n = indentation(state.position, contact);
    double free = link.free_motion - own * link.force;
    for (const auto& other : state.active)
      free += 0.5 * couplings_.mutual(c, index(other.coupling)) * other.force;
    const auto force = [&](double depth) { return depth > 0.0 ? contact.law.force(depth) : 0.0; };
    double d = free;
    for (int i = 0; i < kMostSteps; ++i) {
      const double mean = 0.5 * d;
      const bool close = std::abs(d) <= 1e-7 * std::abs(n);
      link.force =
          close ? force(n - mean) : (contact_energy(contact.law, n) - contact_energy(contact.law, n - d)) / d;
      const double slope =
          close ? (n > 0.0 ? -0.5 * contact.law.stiffness(n) : 0.0) : (force(n - d) - link.force) / d;
      const double excess = free + own * link.force - d, by = excess / (1.0 - own * std::min(0.0, slope));
      d += by;
      if (!(std::abs(by) > 1e-15 * std::abs(d))) break;
    }
    link.motion = d;
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
  std::vector<SolverTables::DrivenColumn> driven_columns_;
  SparseSolver solver_, start_solver_;
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
