#include "engine/physics/network.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cassert>
#include <cmath>

namespace tactus {
namespace {

// Up to here eigenvalues are computed; beyond, the row sums bound them (Gershgorin).
constexpr int kMostEigenvalues = 64;
// 8 MB of matrix: well beyond what could run in real time.
constexpr int kMostCoupledMasses = 1024;
// Fewer masses are stepped faster one by one.
constexpr int kShortestRow = 16;
// What the passive solver keeps for its contacts, each with each and with every mass.
constexpr std::size_t kMostContactNumbers = 8'000'000;

}  // namespace

/// K and C as entries: rows are masses, columns masses and driven points. What fixed points do is in
/// `constant`.
struct Network::Links {
  std::vector<LinkOperator::Entry> entries;
  std::vector<double> constant;

  Eigen::MatrixXd dense(int masses, double k_factor, double b_factor) const {
    Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(masses, masses);
    for (const auto& e : entries)
      if (e.column < masses) matrix(e.row, e.column) += k_factor * e.k + b_factor * e.b;
    return matrix;
  }
};

Result<Network> Network::make(NetworkElements elements, int signals, Hertz rate, Solver solver,
                              int oversample) {
  assert(rate.value > 0.0 && oversample >= 1);
  Network network;
  network.signals_ = signals;
  network.oversample_ = oversample;
  network.k_ = 1.0 / (rate.value * oversample);
  network.solver_ = solver;
  network.take_points(elements);
  network.take_links(elements);
  if (solver == Solver::Passive) network.choose_springs();
  const auto links = network.assemble();
  network.links_ = LinkOperator(links.entries, links.constant);
  if (solver == Solver::Explicit && network.masses_ >= kShortestRow) network.line_up(links.constant);
  if (solver == Solver::Passive)
    if (auto status = network.factor(links); !status) return tl::unexpected(status.error());
  return network;
}

Network::Driven Network::driven(int slot, const Drive& drive) {
  if (!drive.bandwidth) return {slot, drive, -1};
  low_passes_.emplace_back(*drive.bandwidth, Hertz{1.0 / k_});
  return {slot, drive, static_cast<int>(low_passes_.size()) - 1};
}

void Network::take_points(NetworkElements& elements) {
  for (auto& coil : elements.coils) {
    if (coil.against >= 0) continue;
    coil.against = static_cast<int>(elements.points.size());
    elements.points.emplace_back().kind = Point::Kind::Ground;
  }
  slot_.resize(elements.points.size());
  for (const auto kind : {Point::Kind::Mass, Point::Kind::Motion, Point::Kind::Ground}) {
    for (std::size_t i = 0; i < elements.points.size(); ++i) {
      const auto& point = elements.points[i];
      if (point.kind != kind) continue;
      slot_[i] = static_cast<int>(start_position_.size());
      start_position_.push_back(point.position);
      start_velocity_.push_back(kind == Point::Kind::Mass ? point.velocity : 0.0);
      if (kind == Point::Kind::Mass) mass_.push_back(point.mass);
      if (kind == Point::Kind::Mass) scale_.push_back(k_ * k_ / point.mass);
      if (kind == Point::Kind::Motion) motions_.push_back(driven(slot_[i], point.drive));
    }
  }
  masses_ = static_cast<int>(mass_.size());
}

void Network::take_links(const NetworkElements& elements) {
  const auto slot = [this](int point) { return slot_[static_cast<std::size_t>(point)]; };
  springs_ = elements.springs;
  for (auto& spring : springs_) spring.lower = slot(spring.lower), spring.upper = slot(spring.upper);
  for (const auto& c : elements.contacts)
    contacts_.push_back({slot(c.lower), slot(c.upper), c.offset, c.loss,
                         c.restitution ? loss_for_restitution(*c.restitution) : 0.0,
                         ContactLaw(c.stiffness, c.exponent)});
  for (const auto& force : elements.forces) forces_.push_back(driven(slot(force.on), force.drive));
  for (const auto& coil : elements.coils) {
    const double memory = 2.0 * coil.inductance / k_;
    coils_.push_back({slot(coil.on), slot(coil.against), coil.force_factor, coil.inductance, coil.resistance,
                      memory, memory + coil.resistance,
                      memory > 0.0 ? std::exp(-coil.resistance / memory) : 0.0, coil.voltage});
  }
}

Network::Links Network::assemble() const {
  Links links{{}, std::vector<double>(mass_.size())};
  const int columns = masses_ + static_cast<int>(motions_.size());
  // The force on `row` of a link that pulls it towards `other`.
  const auto pull = [&](int row, int other, double stiffness, double damping, double rest) {
    if (!is_mass(row)) return;
    links.entries.push_back({row, row, stiffness, damping / k_});
    links.constant[static_cast<std::size_t>(row)] += stiffness * rest;
    if (other < columns)
      links.entries.push_back({row, other, -stiffness, -damping / k_});
    else
      links.constant[static_cast<std::size_t>(row)] +=
          stiffness * start_position_[static_cast<std::size_t>(other)];
  };
  for (const auto& s : springs_) {
    pull(s.lower, s.upper, s.stiffness, s.damping, -s.rest);
    pull(s.upper, s.lower, s.stiffness, s.damping, s.rest);
  }
  for (const auto& c : coils_) {
    const double damping = c.force_factor * c.force_factor / c.impedance;
    pull(c.on, c.against, 0.0, damping, 0.0);
    pull(c.against, c.on, 0.0, damping, 0.0);
  }
  return links;
}

/// An upper bound of the largest eigenvalue of M^-1 K, exact for small networks. [1/s^2]
double Network::stiffest() const {
  const auto links = assemble();
  if (masses_ > kMostEigenvalues) {
    std::vector<double> sums(mass_.size());
    for (const auto& e : links.entries)
      if (e.column < masses_) sums[static_cast<std::size_t>(e.row)] += std::abs(e.k);
    double most = 0.0;
    for (std::size_t i = 0; i < sums.size(); ++i) most = std::max(most, sums[i] / mass_[i]);
    return most;
  }
  if (masses_ == 0) return 0.0;
  const Eigen::VectorXd root =
      Eigen::Map<const Eigen::VectorXd>(mass_.data(), masses_).cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd matrix = root.asDiagonal() * links.dense(masses_, 1.0, 0.0) * root.asDiagonal();
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(matrix, Eigen::EigenvaluesOnly)
      .eigenvalues()
      .maxCoeff();
}

void Network::choose_springs() { averaged_ = !(stiffest() * k_ * k_ <= 0.99 * 4.0); }  // too stiff, or NaN

Status Network::factor(const Links& links) {
  const double k_share = averaged_ ? 0.25 : 0.0;
  bool coupled = false;
  for (const auto& e : links_.entries()) {
    const double a = k_share * e.k + 0.5 * e.b;
    if (a == 0.0 || e.row == e.column) continue;
    if (e.column < masses_)
      coupled = true;
    else
      couplings_.push_back({e.row, e.column, a});
  }
  if (coupled && masses_ > kMostCoupledMasses)
    return fail(Errc::OutOfRange, {},
                "dampers join " + std::to_string(masses_) + " masses, more than the " +
                    std::to_string(kMostCoupledMasses) + " that the passive solver takes",
                "use solver = \"explicit\"");
  if (contacts_.size() * (mass_.size() + 2 * contacts_.size()) > kMostContactNumbers)
    return fail(Errc::OutOfRange, {},
                std::to_string(contacts_.size()) + " contacts among " + std::to_string(masses_) +
                    " masses are more than the passive solver takes",
                "use solver = \"explicit\"");
  Eigen::VectorXd diagonal = Eigen::Map<const Eigen::VectorXd>(scale_.data(), masses_).cwiseInverse();
  if (coupled) {
    Eigen::MatrixXd matrix = links.dense(masses_, k_share, 0.5);
    matrix.diagonal() += diagonal;
    solver_matrix_ = BandSolver({matrix.data(), static_cast<std::size_t>(matrix.size())}, masses_);
  } else {
    for (const auto& e : links_.entries())
      if (e.row == e.column) diagonal[e.row] += k_share * e.k + 0.5 * e.b;
    solver_matrix_ = BandSolver({diagonal.data(), static_cast<std::size_t>(masses_)});
  }
  if (!solver_matrix_.valid())
    return fail(Errc::OutOfRange, {}, "its masses, springs and dampers are too far apart for the solver",
                "look for a number that is much too large or too small");
  couple_contacts();
  return {};
}

void Network::couple_contacts() {
  const auto count = contacts_.size(), masses = mass_.size();
  columns_.assign(count * masses, 0.0);
  mutual_.assign(count * count, 0.0);
  for (std::size_t c = 0; c < count; ++c) {
    const std::span<double> column(columns_.data() + c * masses, masses);
    if (is_mass(contacts_[c].lower)) column[static_cast<std::size_t>(contacts_[c].lower)] += 1.0;
    if (is_mass(contacts_[c].upper)) column[static_cast<std::size_t>(contacts_[c].upper)] -= 1.0;
    solver_matrix_.solve(column);
    for (std::size_t other = 0; other < count; ++other) {
      const auto [lower, upper] = std::pair{contacts_[other].lower, contacts_[other].upper};
      double& w = mutual_[other * count + c];
      if (is_mass(lower)) w += column[static_cast<std::size_t>(lower)];
      if (is_mass(upper)) w -= column[static_cast<std::size_t>(upper)];
    }
  }
}

void Network::line_up(std::vector<double> constant) {
  std::vector<LinkOperator::Entry> jumps;
  row_ = MassRow(links_.entries(), scale_, jumps);
  std::vector<bool> pushed(mass_.size(), !jumps.empty());
  for (std::size_t i = 0; i < pushed.size(); ++i)
    if (constant[i] != 0.0) pushed[i] = true;
  const auto push = [&](int slot) {
    if (is_mass(slot)) pushed[static_cast<std::size_t>(slot)] = true;
  };
  for (const auto& force : forces_) push(force.slot);
  for (const auto& contact : contacts_) push(contact.lower), push(contact.upper);
  for (const auto& coil : coils_) push(coil.on), push(coil.against);
  row_.let_push(pushed);
  in_row_ = true;
  constant_ = constant;
  jumps_ = LinkOperator(std::move(jumps), std::move(constant));
}

NetworkState Network::initial_state() const {
  NetworkState state;
  for (auto* list : {&state.position, &state.moved, &state.moved_before, &state.change})
    list->resize(start_position_.size());
  state.root.resize(contacts_.size());
  state.loss.resize(contacts_.size());
  state.touching.reserve(contacts_.size());
  if (solver_ == Solver::Passive) state.matrix.resize(contacts_.size() * contacts_.size());
  state.right.resize(contacts_.size());
  for (auto* list : {&state.current, &state.mean_current, &state.voltage}) list->resize(coils_.size());
  state.force.resize(forces_.size());
  state.low_pass.resize(low_passes_.size());
  state.held.resize(static_cast<std::size_t>(signals_));
  reset(state);
  return state;
}

double Network::spectral_radius() const {
  const auto links = assemble();
  const int n = masses_;
  const auto identity = Eigen::MatrixXd::Identity(n, n);
  Eigen::MatrixXd a = Eigen::Map<const Eigen::VectorXd>(scale_.data(), n).cwiseInverse().asDiagonal();
  if (solver_ == Solver::Passive) a += links.dense(n, averaged_ ? 0.25 : 0.0, 0.5);
  const Eigen::MatrixXd from_q = -a.ldlt().solve(links.dense(n, 1.0, 0.0));
  const Eigen::MatrixXd from_u = identity - a.ldlt().solve(links.dense(n, 0.0, 1.0));
  Eigen::MatrixXd step(2 * n, 2 * n);
  step << identity + from_q, from_u, from_q, from_u;
  return Eigen::EigenSolver<Eigen::MatrixXd>(step, false).eigenvalues().cwiseAbs().maxCoeff();
}

}  // namespace tactus
