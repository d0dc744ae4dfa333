#include "engine/physics/solvers/exact_scheme.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <unsupported/Eigen/MatrixFunctions>

#include "engine/physics/index.h"

namespace tactus {
/// The rates of a group's states in the time of a step, d x / d(t/k) = A x + B u, scaled so that A is about
/// as large as its eigenvalues: columns of B are forces on the masses, voltages, and driven points' places
/// and ways.
struct ExactScheme::Rates {
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

  const NetworkModel& model;
  const Group& group;
  int masses;
  Matrix a, b;
  Eigen::VectorXd constant, unit;
};

Result<std::unique_ptr<Scheme>> ExactScheme::make(const NetworkModel& model) {
  std::unique_ptr<ExactScheme> scheme(new ExactScheme(model));
  for (auto& group : groups_of(model))
    if (auto status = scheme->add(std::move(group)); !status) return tl::unexpected(status.error());
  if (auto status = scheme->couple(); !status) return tl::unexpected(status.error());
  return scheme;
}

std::vector<ExactScheme::Group> ExactScheme::groups_of(const NetworkModel& model) {
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

std::optional<double> ExactScheme::multiplications(const NetworkModel& model) {
  double sum = 0.0;
  for (const auto& group : groups_of(model)) {
    if (group.states() > kMostStates) return std::nullopt;
    sum += static_cast<double>(group.states()) * (group.states() + 2.0);
  }
  return sum;
}

Status ExactScheme::add(Group group) {
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
  const auto column = [&](int input) { return whole.col(states + input); };
  Block block;
  block.unit = whole.middleCols(states, rates.masses);
  block.constant = block.unit * rates.constant;
  std::vector<Eigen::VectorXd> columns;
  const auto enter = [&](Input::From from, std::size_t source, const Eigen::VectorXd& does) {
    if (does.isZero(0.0)) return;
    block.inputs.push_back({from, static_cast<int>(source)});
    columns.push_back(does);
  };
  for (std::size_t i = 0; i < model_.forces.size(); ++i)
    if (const int at = rates.place_of(model_.forces[i].slot); at >= 0)
      enter(Input::From::Force, i, column(at));
  for (std::size_t i = 0; i < model_.ports.size(); ++i)
    if (const int at = rates.place_of(model_.ports[i].wave.slot); at >= 0)
      enter(Input::From::Wave, i, 2.0 * column(at));
  for (std::size_t i = 0; i < group.coils.size(); ++i)
    enter(Input::From::Voltage, index(group.coils[i]), column(rates.voltage(static_cast<int>(i))));
  for (std::size_t i = 0; i < model_.coils.size(); ++i) {
    const auto& coil = model_.coils[i];
    Eigen::VectorXd does = Eigen::VectorXd::Zero(states);
    if (const int at = rates.place_of(coil.on); at >= 0) does += column(at);
    if (const int at = rates.place_of(coil.against); at >= 0) does -= column(at);
    if (!(coil.inductance > 0.0)) enter(Input::From::Voltage, i, coil.force_factor / coil.resistance * does);
  }
  for (std::size_t i = 0; i < model_.motions.size(); ++i) {
    enter(Input::From::Place, i, column(rates.place(static_cast<int>(i))));
    enter(Input::From::Way, i, column(rates.place(static_cast<int>(i)) + 1));
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

Status ExactScheme::couple() {
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

double ExactScheme::spectral_radius() const {
  double most = 0.0;
  for (const auto& block : blocks_) {
    const auto states = block.group.states();
    const Eigen::EigenSolver<Matrix> solver(block.step.leftCols(states), false);
    most = std::max(most, solver.eigenvalues().cwiseAbs().maxCoeff());
  }
  return most;
}

}  // namespace tactus
