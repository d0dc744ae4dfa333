#include "engine/physics/solvers/exact_solver.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <unsupported/Eigen/MatrixFunctions>

#include "engine/core/index.h"
#include "engine/physics/numbers.h"

namespace tactus {
namespace {

using View = Eigen::Map<Eigen::VectorXd>;

}  // namespace

/// The rates of a group's states in the time of a step, d x / d(t/k) = A x + B u, scaled so that A is about
/// as large as its eigenvalues: columns of B are forces on the masses, voltages, and driven points' places
/// and ways.
struct ExactSolver::Rates {
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
    const Matrix power = rates.exp();
    Matrix step = power.topRows(states);
    step = unit.asDiagonal() * step;
    step.leftCols(states) = step.leftCols(states) * unit.cwiseInverse().asDiagonal();
    return step;
  }

  /// What enters, and what it does to the states: columns of [Phi | G].
  std::vector<std::pair<Input, Eigen::VectorXd>> inputs(const Matrix& whole) const {
    std::vector<std::pair<Input, Eigen::VectorXd>> all;
    const auto add = [&](Input::From from, std::size_t source, const Eigen::VectorXd& does) {
      all.push_back({{from, static_cast<int>(source)}, does});
    };
    const auto column = [&](int input) { return whole.col(a.rows() + input); };
    for (std::size_t i = 0; i < model.forces.size(); ++i)
      if (const int at = place_of(model.forces[i].slot); at >= 0) add(Input::From::Force, i, column(at));
    for (std::size_t i = 0; i < model.ports.size(); ++i)
      if (const int at = place_of(model.ports[i].wave.slot); at >= 0)
        add(Input::From::Wave, i, 2.0 * column(at));
    for (std::size_t i = 0; i < group.coils.size(); ++i)
      add(Input::From::Voltage, index(group.coils[i]), column(voltage(static_cast<int>(i))));
    for (std::size_t i = 0; i < model.coils.size(); ++i) {
      const auto& coil = model.coils[i];
      if (coil.inductance > 0.0) continue;
      Eigen::VectorXd does = Eigen::VectorXd::Zero(a.rows());
      if (const int at = place_of(coil.on); at >= 0) does += column(at);
      if (const int at = place_of(coil.against); at >= 0) does -= column(at);
      add(Input::From::Voltage, i, coil.force_factor / coil.resistance * does);
    }
    for (std::size_t i = 0; i < model.motions.size(); ++i) {
      add(Input::From::Place, i, column(place(static_cast<int>(i))));
      add(Input::From::Way, i, column(place(static_cast<int>(i)) + 1));
    }
    return all;
  }

  const NetworkModel& model;
  const Group& group;
  int masses;
  Matrix a, b;
  Eigen::VectorXd constant, unit;
};

Result<std::unique_ptr<NetworkSolver>> ExactSolver::make(const NetworkModel& model) {
  std::unique_ptr<ExactSolver> solver(new ExactSolver(model));
  for (auto& group : groups_of(model))
    if (auto status = solver->add(std::move(group)); !status) return tl::unexpected(status.error());
  if (auto status = solver->couple(); !status) return tl::unexpected(status.error());
  return solver;
}

std::vector<ExactSolver::Group> ExactSolver::groups_of(const NetworkModel& model) {
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

Status ExactSolver::add(Group group) {
  if (group.states() > kMostStates)
    return fail(Errc::OutOfRange, {},
                "springs and dampers join " + std::to_string(group.masses.size()) +
                    " masses, more than the " + std::to_string(kMostStates / 2) +
                    " that the exact solver takes",
                "use solver = \"passive\" or \"implicit\"");
  const Rates rates(model_, model_.links(false), group);
  const Matrix whole = rates.step();
  if (!whole.allFinite())
    return fail(Errc::OutOfRange, {}, "its masses, springs and dampers are too far apart for the solver",
                "look for a number that is much too large or too small");
  const int states = group.states();
  Block block;
  block.unit = whole.middleCols(states, rates.masses);
  block.constant = block.unit * rates.constant;
  std::vector<Eigen::VectorXd> columns;
  for (auto& [input, column] : rates.inputs(whole)) {
    if (column.isZero(0.0)) continue;
    block.inputs.push_back(input);
    columns.push_back(std::move(column));
  }
  block.step.resize(states, states + static_cast<int>(columns.size()));
  block.step.leftCols(states) = whole.leftCols(states);
  for (std::size_t i = 0; i < columns.size(); ++i) block.step.col(states + static_cast<int>(i)) = columns[i];
  places_.resize(model_.mass.size());
  for (std::size_t i = 0; i < group.masses.size(); ++i)
    places_[index(group.masses[i])] = {static_cast<int>(blocks_.size()), static_cast<int>(i)};
  block.group = std::move(group);
  if (!blocks_.empty()) block.first = blocks_.back().first + blocks_.back().group.states();
  blocks_.push_back(std::move(block));
  return {};
}

Status ExactSolver::couple() {
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

void ExactSolver::start(NetworkState& state) const noexcept {
  std::copy(model_.start_velocity.begin(), model_.start_velocity.end(), state.velocity.begin());
  for (std::size_t c = 0; c < model_.contacts.size(); ++c) {
    const auto& contact = model_.contacts[c];
    const auto lower = index(contact.lower), upper = index(contact.upper);
    const double n = state.position[lower] - state.position[upper] + contact.offset;
    state.loss[c] = contact.loss;
    if (n > 0.0)
      start_contact(model_, state, c, n,
                    std::max(n, model_.k * (state.velocity[lower] - state.velocity[upper])));
  }
  store_energy(state);
}

void ExactSolver::store_energy(NetworkState& state) const noexcept { couplings_.store_energy(state); }

void ExactSolver::step(NetworkState& state) const noexcept {
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

double ExactSolver::input(const NetworkState& state, const Input& from) const noexcept {
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
void ExactSolver::flow(NetworkState& state, const Block& block) const noexcept {
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

void ExactSolver::push(NetworkState& state) const noexcept {
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

void ExactSolver::arrive(NetworkState& state, const Block& block) const noexcept {
  const double* x = state.flow.data() + block.first;
  for (const int slot : block.group.masses) state.position[index(slot)] = *x++;
  for (const int slot : block.group.masses) state.velocity[index(slot)] = *x++ / model_.k;
  for (const int coil : block.group.coils) state.current[index(coil)] = *x++;
}

void ExactSolver::send_waves(NetworkState& state) const noexcept {
  for (std::size_t i = 0; i < model_.ports.size(); ++i) {
    const auto& port = model_.ports[i];
    state.wave_back[i] += state.wave[i] - port.impedance * state.change[index(port.wave.slot)] / model_.k;
  }
}

double ExactSolver::velocity(const NetworkState& state, int slot) const noexcept {
  return state.velocity[index(slot)];
}

double ExactSolver::current(const NetworkState& state, int coil) const noexcept {
  const auto& c = model_.coils[index(coil)];
  if (c.inductance > 0.0) return state.current[index(coil)];
  const double speed = state.velocity[index(c.on)] - state.velocity[index(c.against)];
  return (state.voltage[index(coil)] - c.force_factor * speed) / c.resistance;
}

double ExactSolver::energy(const NetworkState& state) const noexcept {
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

NetworkSolver::Cost ExactSolver::cost() const {
  double step = 4.0 * static_cast<double>(couplings_.count()), contact = 40.0;
  for (const auto& block : blocks_) {
    step += static_cast<double>(block.step.size());
    contact += block.group.states();
  }
  return {step, contact};
}

}  // namespace tactus
