#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "engine/core/index.h"
#include "engine/physics/change_over.h"
#include "engine/physics/numbers.h"
#include "engine/physics/solvers/network_solver.h"
#include "engine/physics/solvers/solver_tables.h"

namespace tactus {
namespace {

using Matrix = Eigen::MatrixXd;
using View = Eigen::Map<Eigen::VectorXd>;

// Masses and coils of one group: beyond, the other solvers are cheaper by far.
constexpr int kMostStates = 256;

/// Masses that are joined, and what they hold: q of each, k q' of each, i of each coil with an inductance.
struct Group {
  std::vector<int> masses, coils;
  int states() const { return static_cast<int>(2 * masses.size() + coils.size()); }
};
/// A column of a block's matrix: something that enters, or how far a driven point goes in the step.
struct Input {
  AlignedNumbers NetworkState::*list;
  std::size_t at;
};
struct Block {
  Group group;
  std::vector<Input> inputs;
  Matrix step;               ///< [Phi | G], a column for each state and each input
  Eigen::VectorXd constant;  ///< c
  Matrix unit;               ///< what a force of 1 N on each of its masses does to its states
  int first = 0;             ///< in `NetworkState::flow`
};

/// Where a mass is.
struct Place {
  int block, row;
};

/// The rates of a group's states in the time of a step, d x / d(t/k) = A x + B u, scaled so that A is about
/// as large as its eigenvalues: columns of B are forces on the masses, voltages, and driven points' places
/// and ways.
struct Rates {
  Rates(const NetworkModel& of, const NetworkModel::Links& links, const Group& members)
      : model(of), group(members), masses(static_cast<int>(members.masses.size())) {
    const int states = group.states(), coils = static_cast<int>(group.coils.size());
    const int driven = static_cast<int>(model.motions.size());
    a = Matrix::Zero(states, states);
    b = Matrix::Zero(states, masses + coils + 2 * driven);
    constant = Eigen::VectorXd::Zero(masses);
    for (int i = 0; i < masses; ++i) {
      a(i, masses + i) = 1.0;
      b(masses + i, i) = model.scale[index(mass(i))];
      constant[i] = links.constant[index(mass(i))];
    }
    for (const auto& e : links.entries) add(e);
    for (int i = 0; i < coils; ++i) add_coil(i);
    scale();
  }

  int mass(int i) const { return group.masses[index(i)]; }
  int place_of(int slot) const {
    const auto at = std::find(group.masses.begin(), group.masses.end(), slot);
    return at == group.masses.end() ? -1 : static_cast<int>(at - group.masses.begin());
  }
  int voltage(int coil) const { return masses + coil; }
  int place(int driven) const { return masses + static_cast<int>(group.coils.size()) + 2 * driven; }

  void add(const LinkOperator::Entry& e) {
    const int row = place_of(e.row);
    if (row < 0) return;
    const double s = model.scale[index(e.row)];
    if (e.column >= model.masses) {
      const int column = place(e.column - model.masses);
      b(masses + row, column) -= s * e.k;
      b(masses + row, column + 1) -= s * e.b;
    } else {
      const int column = place_of(e.column);
      if (column < 0) return;  // a link without stiffness and damping joins nothing
      a(masses + row, column) -= s * e.k;
      a(masses + row, masses + column) -= s * e.b;
    }
  }

  void add_coil(int i) {
    const auto& coil = model.coils[index(group.coils[index(i)])];
    const int current = 2 * masses + i;
    a(current, current) -= model.k * coil.resistance / coil.inductance;
    b(current, voltage(i)) = model.k / coil.inductance;
    for (const auto& [slot, sign] : {std::pair{coil.on, 1.0}, std::pair{coil.against, -1.0}}) {
      const double induced = -sign * coil.force_factor / coil.inductance;
      if (model.is_mass(slot)) {
        const int row = place_of(slot);
        a(masses + row, current) += sign * model.scale[index(slot)] * coil.force_factor;
        a(current, masses + row) += induced;
      } else if (model.moves(slot)) {
        b(current, place(slot - model.masses) + 1) += induced;
      }
    }
  }

  /// Coordinates whose squares are energies.
  void scale() {
    unit = Eigen::VectorXd(a.rows());
    for (int i = 0; i < masses; ++i) {
      const double root = std::sqrt(model.mass[index(mass(i))]);
      unit[masses + i] = 1.0 / root;
      unit[i] = 1.0 / (root * std::max(1.0, std::sqrt(-a(masses + i, i))));
    }
    for (std::size_t i = 0; i < group.coils.size(); ++i)
      unit[2 * masses + static_cast<int>(i)] =
          1.0 / (model.k * std::sqrt(model.coils[index(group.coils[i])].inductance));
    a = unit.cwiseInverse().asDiagonal() * a * unit.asDiagonal();
    b = unit.cwiseInverse().asDiagonal() * b;
  }

  /// [Phi | G] over one step. A driven point's place goes on with its way.
  Matrix step() const {
    const auto states = a.rows(), inputs = b.cols(), all = states + inputs;
    Matrix rates = Matrix::Zero(all, all);
    rates.topLeftCorner(states, states) = a;
    rates.topRightCorner(states, inputs) = b;
    for (int d = 0; d < static_cast<int>(model.motions.size()); ++d)
      rates(states + place(d), states + place(d) + 1) = 1.0;
    Matrix step = change_over(rates).topRows(states);
    step.leftCols(states) += Matrix::Identity(states, states);
    step = unit.asDiagonal() * step;
    step.leftCols(states) = step.leftCols(states) * unit.cwiseInverse().asDiagonal();
    return step;
  }

  /// add(input, does) for all that enters: what it does to the states, a column of [Phi | G].
  template <class Add>
  void each_input(const Matrix& whole, const Add& add) const {
    using S = NetworkState;
    const auto column = [&](int input) { return whole.col(a.rows() + input); };
    for (int i = 0; i < std::ssize(model.forces); ++i)
      if (const int at = place_of(model.forces[index(i)].on); at >= 0) add({&S::force, index(i)}, column(at));
    for (int i = 0; i < std::ssize(model.ports); ++i)
      if (const int at = place_of(model.ports[index(i)].on); at >= 0)
        add({&S::wave, index(i)}, 2.0 * column(at));
    for (int i = 0; i < std::ssize(group.coils); ++i)
      add({&S::voltage, index(group.coils[index(i)])}, column(voltage(i)));
    for (int i = 0; i < std::ssize(model.coils); ++i) {
      const auto& coil = model.coils[index(i)];
      if (coil.inductance > 0.0) continue;
      Eigen::VectorXd does = Eigen::VectorXd::Zero(a.rows());
      if (const int at = place_of(coil.on); at >= 0) does += column(at);
      if (const int at = place_of(coil.against); at >= 0) does -= column(at);
      add({&S::voltage, index(i)}, coil.force_factor / coil.resistance * does);
    }
    for (int i = 0; i < std::ssize(model.motions); ++i) {
      const auto slot = index(model.motions[index(i)].on);
      add({&S::position, slot}, column(place(i)));
      add({&S::change, slot}, column(place(i) + 1));
    }
  }

  const NetworkModel& model;
  const Group& group;
  int masses;
  Matrix a, b;
  Eigen::VectorXd constant, unit;
};

std::vector<Group> groups_of(const NetworkModel& model) {
  std::vector<int> parent(index(model.masses) + model.coils.size());
  std::iota(parent.begin(), parent.end(), 0);
  const auto find = [&](int i) {
    while (parent[index(i)] != i) i = parent[index(i)] = parent[index(parent[index(i)])];
    return i;
  };
  const auto join = [&](int one, int other) { parent[index(find(one))] = find(other); };
  for (const auto& e : model.links(false).entries)
    if (e.column < model.masses && (e.k != 0.0 || e.b != 0.0)) join(e.row, e.column);
  for (std::size_t c = 0; c < model.coils.size(); ++c)
    for (const int slot : {model.coils[c].on, model.coils[c].against})
      if (model.is_mass(slot) && model.coils[c].inductance > 0.0)
        join(slot, model.masses + static_cast<int>(c));
  std::vector<int> group_of(parent.size(), -1);
  std::vector<Group> groups;
  for (int i = 0; i < static_cast<int>(parent.size()); ++i) {
    const bool coil = i >= model.masses;
    if (coil && !(model.coils[index(i - model.masses)].inductance > 0.0)) continue;
    auto& at = group_of[index(find(i))];
    if (at < 0) at = static_cast<int>(groups.size()), groups.emplace_back();
    auto& group = groups[index(at)];
    (coil ? group.coils : group.masses).push_back(coil ? i - model.masses : i);
  }
  return groups;
}

class ExactSolver final : public NetworkSolver {
 public:
  explicit ExactSolver(const NetworkModel& model) : model_(model) {}

  Status make() {
    Status status;
    for (auto& group : groups_of(model_))
      if (status) status = add(std::move(group));
    return status ? couple() : status;
  }

  void start(NetworkState& state) const noexcept override {
    std::copy(model_.start_velocity.begin(), model_.start_velocity.end(), state.velocity.begin());
    for (std::size_t c = 0; c < model_.contacts.size(); ++c)
      start_loss(model_, state, c, model_.k * between(state.velocity, model_.contacts[c]));
    store_energy(state);
  }

  void store_energy(NetworkState& state) const noexcept override { couplings_.store_energy(state); }

  void step(NetworkState& state) const noexcept override {
    for (std::size_t i = 0; i < model_.motions.size(); ++i) {
      const auto slot = index(model_.motions[i].on);
      state.change[slot] = state.next[i] - state.position[slot];
    }
    for (const auto& block : blocks_) flow(state, block);
    if (!couplings_.empty()) {
      couplings_.solve(state);
      push(state);
      couplings_.finish(state);
      halt(state);
    }
    model_.send_waves(state, [&](int slot) { return state.change[index(slot)]; });
    for (const auto& block : blocks_) arrive(state, block);
    for (std::size_t i = 0; i < model_.motions.size(); ++i) {
      const auto slot = index(model_.motions[i].on);
      state.velocity[slot] = state.change[slot] / model_.k;
      state.position[slot] = state.next[i];
    }
  }

  double current(const NetworkState& state, int coil) const noexcept override {
    const auto& c = model_.coils[index(coil)];
    if (c.inductance > 0.0) return state.current[index(coil)];
    const double speed = state.velocity[index(c.on)] - state.velocity[index(c.against)];
    return (state.voltage[index(coil)] - c.force_factor * speed) / c.resistance;
  }

  double energy(const NetworkState& state) const noexcept override {
    double sum = model_.linear_energy(state);
    for (const double root : state.root) sum += 0.5 * square(root);
    return model_.with_inductances(sum, state);
  }

  Cost cost() const override {
    double step = 4.0 * static_cast<double>(couplings_.count()), contact = 40.0;
    for (const auto& block : blocks_) {
      step += static_cast<double>(block.step.size());
      contact += block.group.states();
    }
    return {step, contact};
  }
  bool centred() const override { return false; }
  SolverTables tables() const override {
    SolverTables tables{.couplings = &couplings_};
    for (const auto& block : blocks_) {
      const auto list = [](const auto& matrix) {
        return std::vector<double>(matrix.data(), matrix.data() + matrix.size());
      };
      auto& group = tables.groups.emplace_back(SolverTables::Group{block.group.masses,
                                                                   block.group.coils,
                                                                   {},
                                                                   list(block.step),
                                                                   list(block.constant),
                                                                   list(block.unit)});
      for (const auto& input : block.inputs)
        group.inputs.push_back({kind_of(input), static_cast<int>(input.at)});
    }
    return tables;
  }

 private:
  static SolverTables::Entering kind_of(const Input& input) {
    using S = NetworkState;
    using enum SolverTables::Entering;
    return input.list == &S::force      ? Force
           : input.list == &S::wave     ? Wave
           : input.list == &S::voltage  ? Voltage
           : input.list == &S::position ? Place
                                        : Way;
  }

  Status add(Group group) {
    if (group.states() > kMostStates)
      return fail(Errc::OutOfRange, {},
                  "springs and dampers connect " + std::to_string(group.masses.size()) +
                      " masses, more than the " + std::to_string(kMostStates / 2) +
                      " that the exact solver supports",
                  "use solver = \"passive\" or \"implicit\"");
    const Rates rates(model_, model_.links(false), group);
    const Matrix whole = rates.step();
    if (!whole.allFinite())
      return fail(Errc::OutOfRange, {},
                  "the values of its masses, springs and dampers differ too much for the solver",
                  "look for a value that is much too large or too small");
    const int states = group.states();
    Block block;
    block.unit = whole.middleCols(states, rates.masses);
    block.constant = block.unit * rates.constant;
    block.step = whole.leftCols(states);
    rates.each_input(whole, [&](const Input& input, const Eigen::VectorXd& does) {
      if (does.isZero(0.0)) return;
      block.inputs.push_back(input);
      block.step.conservativeResize(states, block.step.cols() + 1);
      block.step.rightCols(1) = does;
    });
    places_.resize(model_.mass.size());
    for (std::size_t i = 0; i < group.masses.size(); ++i)
      places_[index(group.masses[i])] = {static_cast<int>(blocks_.size()), static_cast<int>(i)};
    block.group = std::move(group);
    if (!blocks_.empty()) block.first = blocks_.back().first + blocks_.back().group.states();
    blocks_.push_back(std::move(block));
    return {};
  }

  Status couple() {
    auto made = Couplings::make(model_, Couplings::Method::Exact, [&](std::span<double> column) {
      for (const auto& block : blocks_) {
        const auto masses = static_cast<int>(block.group.masses.size());
        Eigen::VectorXd forces(masses);
        for (int i = 0; i < masses; ++i) forces[i] = column[index(block.group.masses[index(i)])];
        const Eigen::VectorXd moved = block.unit.topRows(masses) * forces;
        for (int i = 0; i < masses; ++i) column[index(block.group.masses[index(i)])] = moved[i];
      }
    });
    if (!made) return tl::unexpected(made.error());
    couplings_ = std::move(*made);
    return {};
  }

  /// Where the group goes without its couplings.
  void flow(NetworkState& state, const Block& block) const noexcept {
    const auto masses = block.group.masses.size();
    double* x = state.entering.data();
    for (std::size_t i = 0; i < masses; ++i) {
      x[i] = state.position[index(block.group.masses[i])];
      x[masses + i] = model_.k * state.velocity[index(block.group.masses[i])];
    }
    x += 2 * masses;
    for (const int coil : block.group.coils) *x++ = state.current[index(coil)];
    for (const auto& [list, at] : block.inputs) *x++ = (state.*list)[at];
    View to(state.flow.data() + block.first, block.group.states());
    to = block.constant;
    to.noalias() += block.step * View(state.entering.data(), block.step.cols());
    for (std::size_t i = 0; i < masses; ++i)
      state.change[index(block.group.masses[i])] =
          to[static_cast<Eigen::Index>(i)] - state.position[index(block.group.masses[i])];
  }

  void push(NetworkState& state) const noexcept {
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

  /// The force of a step leaves what has stopped with some velocity, which is taken away: energy is only
  /// lost.
  void halt(NetworkState& state) const noexcept {
    for (std::size_t f = 0; f < model_.frictions.size(); ++f) {
      const auto& [lower, upper] = std::pair{model_.frictions[f].lower, model_.frictions[f].upper};
      const double lighter = lightness(lower), light = lighter + lightness(upper);
      if (state.sliding[f] != 0.0 || light == 0.0) continue;
      const double slides = way(state, lower) - way(state, upper);
      if (model_.is_mass(lower)) way(state, lower) -= slides * lighter / light;
      if (model_.is_mass(upper)) way(state, upper) += slides * lightness(upper) / light;
    }
  }
  double lightness(int slot) const noexcept {
    return model_.is_mass(slot) ? 1.0 / model_.mass[index(slot)] : 0.0;
  }
  /// Velocity after the step, times k.
  double& way(NetworkState& state, int slot) const noexcept {
    if (!model_.is_mass(slot)) return state.change[index(slot)];
    const auto& [at, row] = places_[index(slot)];
    const auto& block = blocks_[index(at)];
    return state.flow[index(block.first + static_cast<int>(block.group.masses.size()) + row)];
  }

  void arrive(NetworkState& state, const Block& block) const noexcept {
    const double* x = state.flow.data() + block.first;
    for (const int slot : block.group.masses) state.position[index(slot)] = *x++;
    for (const int slot : block.group.masses) state.velocity[index(slot)] = *x++ / model_.k;
    for (const int coil : block.group.coils) state.current[index(coil)] = *x++;
  }

  const NetworkModel& model_;
  std::vector<Block> blocks_;
  std::vector<Place> places_;
  Couplings couplings_;
};

}  // namespace

Result<std::unique_ptr<NetworkSolver>> make_exact_solver(const NetworkModel& model) {
  auto solver = std::make_unique<ExactSolver>(model);
  if (auto status = solver->make(); !status) return tl::unexpected(status.error());
  return solver;
}

}  // namespace tactus
