#include "engine/physics/network_model.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "engine/core/index.h"

namespace tactus {
namespace {

// Up to here eigenvalues are computed; beyond, the row sums bound them (Gershgorin).
constexpr int kMostEigenvalues = 64;

}  // namespace

NetworkModel::NetworkModel(NetworkElements elements, int signals_, double step_s)
    : k(step_s), signals(signals_) {
  take_points(elements);
  take_links(elements);
}

NetworkModel::Driven NetworkModel::driven(int of, const NetworkInput& input) {
  if (!input.bandwidth) return {of, input, -1};
  low_passes.emplace_back(*input.bandwidth, Hertz{1.0 / k});
  return {of, input, static_cast<int>(low_passes.size()) - 1};
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
      if (kind == Point::Kind::Motion) motions.push_back(driven(slot[i], point.input));
    }
  }
  masses = static_cast<int>(mass.size());
}

void NetworkModel::take_links(NetworkElements& elements) {
  renumber(elements, slot);
  springs = std::move(elements.springs);
  bonds = std::move(elements.bonds);
  for (const auto& c : elements.contacts)
    contacts.push_back({c.lower, c.upper, c.offset, c.loss,
                        c.restitution ? loss_for_restitution(*c.restitution) : 0.0,
                        ContactLaw(c.stiffness, c.exponent)});
  for (const auto& force : elements.forces) forces.push_back(driven(force.on, force.input));
  for (const auto& coil : elements.coils) {
    const double memory = 2.0 * coil.inductance / k;
    coils.push_back({coil.on, coil.against, coil.force_factor, coil.inductance, coil.resistance, memory,
                     memory + coil.resistance, memory > 0.0 ? std::exp(-coil.resistance / memory) : 0.0,
                     driven(coil.on, coil.voltage)});
  }
  for (const auto& f : elements.frictions)
    frictions.push_back(
        {f.lower, f.upper, f.law, f.viscous, driven(f.lower, f.normal), f.normal_contact, f.normal_spring});
  for (const auto& port : elements.ports) ports.push_back({port.impedance, driven(port.on, port.wave)});
}

NetworkModel::Links NetworkModel::links(bool eliminated) const {
  Links links{{}, std::vector<double>(mass.size())};
  const int columns = masses + static_cast<int>(motions.size());
  // The force on `row` of a link that pulls it towards `other`.
  const auto pull = [&](int row, int other, double stiffness, double damping, double rest) {
    if (!is_mass(row)) return;
    links.entries.push_back({row, row, stiffness, damping / k});
    links.constant[index(row)] += stiffness * rest;
    if (other < columns)
      links.entries.push_back({row, other, -stiffness, -damping / k});
    else
      links.constant[index(row)] += stiffness * start_position[index(other)];
  };
  for (const auto& s : springs) {
    pull(s.lower, s.upper, s.stiffness, s.damping, -s.rest);
    pull(s.upper, s.lower, s.stiffness, s.damping, s.rest);
  }
  for (const auto& c : coils) {
    if (c.inductance > 0.0 && !eliminated) continue;
    const double damping = c.force_factor * c.force_factor / c.impedance;
    pull(c.on, c.against, 0.0, damping, 0.0);
    pull(c.against, c.on, 0.0, damping, 0.0);
  }
  for (const auto& port : ports)
    if (is_mass(port.wave.slot))
      links.entries.push_back({port.wave.slot, port.wave.slot, 0.0, port.impedance / k});
  return links;
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

}  // namespace tactus
