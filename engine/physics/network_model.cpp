#include "engine/physics/network_model.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/core/index.h"
#include "engine/physics/parts.h"

namespace tactus {
namespace {

// Up to here eigenvalues are computed; beyond, the row sums bound them (Gershgorin).
constexpr int kMostEigenvalues = 64;

// Time constant of a coil, in steps, below which it has no current of its own: it would delay the current by
// this share of a step.
constexpr double kNoInductance = std::numeric_limits<double>::epsilon();

}  // namespace

NetworkModel::NetworkModel(NetworkElements elements, int signals_, double step_s)
    : k(step_s), signals(signals_) {
  take_points(elements);
  take_links(elements);
}

/// Gives an input that has a bandwidth its low-pass.
void NetworkModel::filter(NetworkInput& input) {
  if (!input.bandwidth) return;
  input.low_pass = static_cast<int>(low_passes.size());
  low_passes.emplace_back(*input.bandwidth, Hertz{1.0 / k});
}

void NetworkModel::take_points(NetworkElements& elements) {
  for (auto& coil : elements.coils) {
    if (coil.against >= 0) continue;
    coil.against = static_cast<int>(elements.points.size());
    elements.points.emplace_back().kind = Point::Kind::Ground;
  }
  slot.resize(elements.points.size());
  for (const auto kind : {Point::Kind::Mass, Point::Kind::Motion, Point::Kind::Ground}) {
    for (std::size_t i = 0; i < elements.points.size(); ++i) {
      const auto& point = elements.points[i];
      if (point.kind != kind) continue;
      slot[i] = static_cast<int>(start_position.size());
      start_position.push_back(point.position);
      start_velocity.push_back(kind == Point::Kind::Mass ? point.velocity : 0.0);
      if (kind == Point::Kind::Mass) mass.push_back(point.mass);
      if (kind == Point::Kind::Mass) scale.push_back(k * k / point.mass);
      if (kind == Point::Kind::Motion) filter(motions.emplace_back(AppliedForce{slot[i], point.input}).input);
    }
  }
  masses = static_cast<int>(mass.size());
}

void NetworkModel::take_links(NetworkElements& elements) {
  renumber_points(elements, slot);
  springs = std::move(elements.springs);
  bonds = std::move(elements.bonds);
  forces = std::move(elements.forces);
  frictions = std::move(elements.frictions);
  ports = std::move(elements.ports);
  for (const auto& c : elements.contacts)
    contacts.push_back(
        {c, c.restitution ? loss_for_restitution(*c.restitution) : 0.0, ContactLaw(c.stiffness, c.exponent)});
  for (auto& force : forces) filter(force.input);
  for (auto& coil : elements.coils) {
    // Its current follows the voltage within a step, but for a share that no double holds.
    if (coil.inductance < kNoInductance * coil.resistance * k) coil.inductance = 0.0;
    const double memory = 2.0 * coil.inductance / k;
    coils.push_back(
        {coil, memory, memory + coil.resistance, memory > 0.0 ? std::exp(-coil.resistance / memory) : 0.0});
    filter(coils.back().voltage);
  }
  for (auto& friction : frictions) filter(friction.normal);
}

NetworkModel::Links NetworkModel::links(bool eliminated) const {
  Links links{{}, std::vector<double>(mass.size())};
  links.entries.reserve(8 * springs.size() + 4 * (coils.size() + ports.size()));
  const int columns = masses + static_cast<int>(motions.size());
  const auto each_damper = [&](const auto& add) {
    for (const auto& s : springs)
      if (s.axes == 1) add(s.lower, s.upper, s.damping);
    for (const auto& c : coils)
      if (eliminated || !(c.inductance > 0.0)) add(c.on, c.against, square(c.force_factor) / c.impedance);
    for (const auto& port : ports) add(port.on, -1, port.impedance);
  };
  // The decay of each mass in a step, by all dampers on it.
  std::vector<double> decay(start_position.size());
  each_damper([&](int lower, int upper, double damping) {
    for (const int end : {lower, upper})
      if (end >= 0 && is_mass(end)) decay[index(end)] += k * damping / mass[index(end)];
  });
  for (const auto& s : springs)
    for (const int end : {s.lower, s.upper})
      for (int a = 0; s.axes > 1 && is_mass(end) && a < s.axes; ++a)
        decay[index(end + a)] += k * s.damping / mass[index(end + a)];
  // The force on `row` of a link that pulls it towards `other`, -1: towards 0.
  const auto pull = [&](int row, int other, double stiffness, double damping, double rest) {
    if (row < 0 || !is_mass(row)) return;
    const double inertia =
        stiff_inertia(damping, decay[index(row)] + (other < 0 ? 0.0 : decay[index(other)]));
    links.entries.push_back({row, row, stiffness, damping / k, inertia});
    links.constant[index(row)] += stiffness * rest;
    if (other < 0) return;
    if (other < columns)
      links.entries.push_back({row, other, -stiffness, -damping / k, -inertia});
    else
      links.constant[index(row)] += stiffness * start_position[index(other)];
  };
  for (const auto& s : springs) {
    if (s.axes > 1) {
      const double r =
          (is_mass(s.lower) ? decay[index(s.lower)] : 0.0) + (is_mass(s.upper) ? decay[index(s.upper)] : 0.0);
      add_line(links, s, stiff_inertia(s.damping, r));
      continue;
    }
    pull(s.lower, s.upper, s.stiffness, 0.0, -s.rest);
    pull(s.upper, s.lower, s.stiffness, 0.0, s.rest);
  }
  each_damper([&](int lower, int upper, double damping) {
    pull(lower, upper, 0.0, damping, 0.0);
    pull(upper, lower, 0.0, damping, 0.0);
  });
  return links;
}

/// K = k b b^T, b = [-n, n] of the axes of both ends.
void NetworkModel::add_line(Links& links, const Spring& s, double inertia) const {
  const int columns = masses + static_cast<int>(motions.size());
  for (const int row_end : {s.lower, s.upper}) {
    if (!is_mass(row_end)) continue;
    const double row_sign = row_end == s.upper ? 1.0 : -1.0;
    for (int i = 0; i < s.axes; ++i) {
      const double of_row = row_sign * s.along[index(i)];
      links.constant[index(row_end + i)] += s.stiffness * of_row * s.rest;
      for (const int end : {s.lower, s.upper}) {
        for (int j = 0; j < s.axes; ++j) {
          const double b = of_row * (end == s.upper ? s.along[index(j)] : -s.along[index(j)]);
          if (b == 0.0) continue;
          if (end + j < columns)
            links.entries.push_back({row_end + i, end + j, b * s.stiffness, b * s.damping / k, b * inertia});
          else
            links.constant[index(row_end + i)] -= b * s.stiffness * start_position[index(end + j)];
        }
      }
    }
  }
}

double NetworkModel::stiffest(double k_share, double b_share) const {
  const auto all = links();
  const auto value = [&](const LinkOperator::Entry& e) { return k_share * e.k + b_share * e.b; };
  if (masses > kMostEigenvalues) {
    std::vector<double> sums(mass.size());
    for (const auto& e : all.entries)
      if (e.column < masses) sums[index(e.row)] += std::abs(value(e));
    double most = 0.0;
    for (std::size_t i = 0; i < sums.size(); ++i) most = std::max(most, sums[i] / mass[i]);
    return most;
  }
  if (masses == 0) return 0.0;
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(masses, masses);
  for (const auto& e : all.entries)
    if (e.column < masses)
      matrix(e.row, e.column) += value(e) / std::sqrt(mass[index(e.row)] * mass[index(e.column)]);
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(matrix, Eigen::EigenvaluesOnly)
      .eigenvalues()
      .maxCoeff();
}

double NetworkModel::linear_energy(const NetworkState& state) const noexcept {
  double sum = 0.0;
  for (std::size_t i = 0; i < mass.size(); ++i) sum += 0.5 * mass[i] * square(state.velocity[i]);
  for (const auto& s : springs) sum += 0.5 * s.stiffness * square(extension(state.position, s));
  return sum;
}

double NetworkModel::with_inductances(double sum, const NetworkState& state) const noexcept {
  for (std::size_t i = 0; i < coils.size(); ++i) sum += 0.5 * coils[i].inductance * square(state.current[i]);
  return sum;
}

}  // namespace tactus
