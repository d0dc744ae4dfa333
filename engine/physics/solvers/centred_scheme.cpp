#include "engine/physics/solvers/centred_scheme.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "engine/physics/index.h"

namespace tactus {
namespace {

// Fewer masses are stepped faster one by one.
constexpr int kShortestRow = 16;

}  // namespace

Result<std::unique_ptr<Scheme>> CentredScheme::make(const NetworkModel& model, Kind kind) {
  std::unique_ptr<CentredScheme> scheme(new CentredScheme(model, kind));
  // Too stiff, or NaN.
  if (kind == Kind::Passive)
    scheme->averaged_ = !(model.stiffest(1.0, 0.0) * model.k * model.k <= 0.99 * 4.0);
  if (kind == Kind::Implicit) scheme->averaged_ = true;
  auto links = model.links();
  scheme->links_ = LinkOperator(std::move(links.entries), links.constant);
  if (scheme->factored())
    if (auto status = scheme->factor(); !status) return tl::unexpected(status.error());
  if (auto status = scheme->slow_start(); !status) return tl::unexpected(status.error());
  if (kind == Kind::Explicit && model.masses >= kShortestRow && model.frictions.empty())
    scheme->line_up(std::move(links.constant));
  if (auto status = scheme->couple(); !status) return tl::unexpected(status.error());
  return scheme;
}

/// Of M/k^2 and of the links so much.
Result<SparseSolver> CentredScheme::solver_of(double k_share, double b_share) const {
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

Status CentredScheme::factor() {
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
Status CentredScheme::slow_start() {
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

Status CentredScheme::couple() {
  using Method = Couplings::Method;
  const auto method = kind_ == Kind::Explicit  ? Method::Pushed
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

void CentredScheme::line_up(std::vector<double> constant) {
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

Scheme::Cost CentredScheme::cost() const {
  const double links = static_cast<double>(links_.entries().size());
  const double touch = kind_ == Kind::Explicit ? 15.0 : kind_ == Kind::Passive ? 40.0 : 150.0;
  const auto solve = factored() ? static_cast<double>(solver_.multiplications()) : 0.0;
  const double couplings = 4.0 * static_cast<double>(couplings_.count());
  return {
      2.0 * links + 2.0 * model_.masses + solve + 12.0 * static_cast<double>(model_.coils.size()) + couplings,
      touch + (factored() ? model_.masses : 0.0)};
}

double CentredScheme::spectral_radius() const {
  const int n = model_.masses;
  if (n == 0) return 0.0;
  const auto dense = [&](double k_factor, double b_factor) {
    Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(n, n);
    for (const auto& e : links_.entries())
      if (e.column < n) matrix(e.row, e.column) += k_factor * e.k + b_factor * e.b;
    return matrix;
  };
  const auto identity = Eigen::MatrixXd::Identity(n, n);
  Eigen::MatrixXd a = Eigen::Map<const Eigen::VectorXd>(model_.scale.data(), n).cwiseInverse().asDiagonal();
  if (factored()) a += dense(averaged_ ? 0.25 : 0.0, 0.5);
  const Eigen::MatrixXd from_q = -a.ldlt().solve(dense(1.0, 0.0));
  const Eigen::MatrixXd from_u = identity - a.ldlt().solve(dense(0.0, 1.0));
  Eigen::MatrixXd step(2 * n, 2 * n);
  step << identity + from_q, from_u, from_q, from_u;
  return Eigen::EigenSolver<Eigen::MatrixXd>(step, false).eigenvalues().cwiseAbs().maxCoeff();
}

double CentredScheme::velocity(const NetworkState& state, int slot) const noexcept {
  return (1.5 * state.moved[index(slot)] - 0.5 * state.moved_before[index(slot)]) / model_.k;
}

double CentredScheme::current(const NetworkState& state, int coil) const noexcept {
  const auto& c = model_.coils[index(coil)];
  const int signal = c.voltage.input.signal;
  const double voltage = signal < 0 ? 0.0 : state.held[index(signal)];
  const double speed = velocity(state, c.on) - velocity(state, c.against);
  const double final_current = (voltage - c.force_factor * speed) / c.resistance;
  return final_current + (state.current[index(coil)] - final_current) * c.half_step_decay;
}

}  // namespace tactus
