#include "engine/physics/linearised.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "engine/core/index.h"

namespace tactus {
namespace {

/// Points that can move; their slots come before those of all others.
std::size_t moving_points(const NetworkElements& elements) {
  return index(std::count_if(elements.points.begin(), elements.points.end(),
                             [](const Point& p) { return p.kind != Point::Kind::Ground; }));
}

/// Every number that a step reads of the state before it, one after the other: the one place that lists them.
/// Of the motions only those that the solver keeps, since the others never change.
void each_number(NetworkState& state, std::size_t moving, const std::function<void(double&)>& visit) {
  const auto all = [&](AlignedNumbers& list) {
    for (std::size_t i = 0; i < moving; ++i) visit(list[i]);
  };
  all(state.position);
  if (state.moved.empty())
    all(state.velocity);
  else
    all(state.moved), all(state.moved_before);
  for (auto* list : {&state.current, &state.voltage, &state.wave, &state.wave_back, &state.held})
    for (double& number : *list) visit(number);
  for (auto& filter : state.low_pass) visit(filter.value), visit(filter.slope);
}

NetworkState still(const Network& network, std::size_t moving) {
  auto state = network.initial_state();
  each_number(state, moving, [](double& number) { number = 0.0; });
  state.settled = true;
  return state;
}

Eigen::VectorXd numbers_of(NetworkState& state, std::size_t moving) {
  std::vector<double> numbers;
  each_number(state, moving, [&](double& number) { numbers.push_back(number); });
  return Eigen::Map<Eigen::VectorXd>(numbers.data(), static_cast<Eigen::Index>(numbers.size()));
}

}  // namespace

std::vector<Spring> line_springs(const Bond& bond, const std::vector<double>& places) {
  const auto r = apart(places, bond);
  const double n = stretch(places, bond), l = length(r);
  const double stiffness = bond.law->stiffness(n), force = bond.law->force(n);
  // Without a length and a rest it is one spring in every direction.
  const double across = l > 0.0 ? force / l : bond.rest == 0.0 ? stiffness : 0.0;
  std::vector<Direction> frame;
  if (l > 0.0) frame.push_back(unit(r));
  for (int a = 0; a < bond.axes && std::ssize(frame) < bond.axes; ++a) {
    Direction next{};
    next[index(a)] = 1.0;
    for (const auto& known : frame) {
      const double part = dot(next, known);
      for (std::size_t i = 0; i < next.size(); ++i) next[i] -= part * known[i];
    }
    if (length(next) > 0.1) frame.push_back(unit(next));  // else little of it but rounding is left
  }
  std::vector<Spring> springs;
  for (const auto& along : frame)
    springs.push_back({bond.upper, bond.lower, across, 0.0, 0.0, bond.axes, along});
  if (l > 0.0) {
    springs.front().stiffness = stiffness, springs.front().damping = bond.damping;
    springs.front().rest = stiffness > 0.0 ? l - force / stiffness : 0.0;
  }
  return springs;
}

NetworkElements tangent(NetworkElements elements, const Touching& touching) {
  constexpr double kFar = -1e9, kNothing = 1e-300;
  for (const int c : touching.contacts) {
    const auto& contact = elements.contacts[index(c)];
    const double depth = std::pow(touching.push / contact.stiffness, 1.0 / contact.exponent);
    Spring spring{contact.lower, contact.upper, contact.exponent * touching.push / depth};
    spring.damping = contact.restitution ? 0.0 : touching.push * contact.loss;
    elements.springs.push_back(spring);
  }
  for (auto& contact : elements.contacts) contact.offset = kFar;
  // What slides or holds is not linear: frictions are not pressed. Bonds hold, at the distance of the start.
  for (auto& friction : elements.frictions) {
    elements.springs.push_back({friction.lower, friction.upper, 0.0, friction.viscous});
    friction.normal = {}, friction.normal_contact = friction.normal_spring = -1, friction.viscous = 0.0;
  }
  std::vector<double> places;
  for (const auto& point : elements.points) places.push_back(point.position);
  for (auto& bond : elements.bonds) {
    if (bond.axes > 1) {
      for (auto& spring : line_springs(bond, places)) {
        spring.rest = 0.0;
        elements.springs.push_back(spring);
      }
      bond.law = std::make_shared<LinearBond>(kNothing), bond.damping = 0.0, bond.axes = 1;
      continue;
    }
    const double n =
        elements.points[index(bond.lower)].position - elements.points[index(bond.upper)].position;
    elements.springs.push_back({bond.upper, bond.lower, bond.law->stiffness(n), bond.damping});
    bond.law = std::make_shared<LinearBond>(kNothing), bond.damping = 0.0;
  }
  return elements;
}

std::size_t state_size(const NetworkElements& elements, int signals) {
  std::size_t low_passes = 0;
  for (const auto& point : elements.points) low_passes += point.input.bandwidth.has_value();
  for (const auto& force : elements.forces) low_passes += force.input.bandwidth.has_value();
  return 3 * moving_points(elements) + 2 * (elements.coils.size() + elements.ports.size()) + index(signals) +
         2 * low_passes;
}

std::vector<NetworkState> unit_states(const Network& network, const NetworkElements& elements, double size) {
  const auto moving = moving_points(elements);
  auto zero = still(network, moving);
  const auto count = numbers_of(zero, moving).size();
  std::vector<NetworkState> states(index(count), zero);
  for (std::size_t i = 0; i < states.size(); ++i) {
    std::size_t at = 0;
    each_number(states[i], moving, [&](double& number) { number = at++ == i ? size : 0.0; });
  }
  return states;
}

LinearStep linear_step(const Network& network, const NetworkElements& elements, int signals) {
  const auto moving = moving_points(elements);
  std::vector<double> inputs(index(signals), 0.0);
  const auto stepped = [&](NetworkState state) -> Eigen::VectorXd {
    network.step(state, inputs.data());
    return numbers_of(state, moving);
  };
  const auto rest = stepped(still(network, moving));
  auto units = unit_states(network, elements, 1.0);
  LinearStep step{Eigen::MatrixXd(rest.size(), rest.size()), Eigen::MatrixXd(rest.size(), signals)};
  for (std::size_t i = 0; i < units.size(); ++i)
    step.a.col(static_cast<Eigen::Index>(i)) = stepped(std::move(units[i])) - rest;
  for (int i = 0; i < signals; ++i) {
    inputs[index(i)] = 1.0;
    step.b.col(i) = stepped(still(network, moving)) - rest;
    inputs[index(i)] = 0.0;
  }
  return step;
}

std::vector<StepMode> modes(const Eigen::MatrixXd& a) {
  const Eigen::EigenSolver<Eigen::MatrixXd> solved(a);
  std::vector<StepMode> modes;
  for (Eigen::Index i = 0; i < a.rows(); ++i)
    modes.push_back({solved.eigenvalues()[i], solved.eigenvectors().col(i)});
  std::stable_sort(modes.begin(), modes.end(),
                   [](const auto& x, const auto& y) { return std::abs(x.pole) > std::abs(y.pole); });
  return modes;
}

double spectral_radius(const Eigen::MatrixXd& a) {
  if (a.rows() == 0) return 0.0;
  return Eigen::EigenSolver<Eigen::MatrixXd>(a, false).eigenvalues().cwiseAbs().maxCoeff();
}

namespace {

/// As noise, but the same each time: the fractions of multiples of the golden ratio (Weyl's sequence).
double scattered(std::size_t i) {
  const double turns = 0.6180339887498949 * static_cast<double>(i + 1);
  return turns - std::floor(turns) - 0.5;
}

}  // namespace

double radius_by_running(const Network& network, const NetworkElements& elements, int signals) {
  constexpr int kFrames = 4000;
  const auto moving = moving_points(elements);
  auto rest = still(network, moving), moved = rest;
  for (std::size_t i = 0; i < moving; ++i) moved.moved[i] = 1e-3 * scattered(i);
  const std::vector<double> inputs(index(signals), 0.0);
  const auto motion = [&] {
    double sum = 0.0;
    for (std::size_t i = 0; i < moving; ++i) sum += std::pow(moved.moved[i] - rest.moved[i], 2);
    return std::sqrt(sum);
  };
  const double start = motion();
  double before = start, now = start;
  for (int frame = 1; frame <= kFrames; ++frame) {
    network.step(moved, inputs.data());
    network.step(rest, inputs.data());
    now = motion();
    if (!(now < 1e100)) return std::pow(1e100 / start, 1.0 / frame);
    if (frame <= kFrames / 2) before = std::max(before, now);
  }
  return now > 7.0 * before ? std::pow(now / before, 2.0 / kFrames) : 1.0;
}

// ---- response

StepResponse::StepResponse(const LinearStep& step, const Eigen::MatrixXd& c,
                           const std::vector<StepMode>& modes) {
  find_modes(step, c, modes);
  const Eigen::HessenbergDecomposition<Eigen::MatrixXd> form(step.a);
  const Eigen::MatrixXd q = form.matrixQ();
  minus_h_ = -form.matrixH().cast<std::complex<double>>();
  b_ = (q.transpose() * step.b).cast<std::complex<double>>();
  c_ = (c * q).cast<std::complex<double>>();
  check_modes();
}

/// Where eigenvectors are less exact than elimination, as of numbers of very different sizes, they are not
/// used.
void StepResponse::check_modes() {
  constexpr double kMostError = 1e-9;
  if (!by_modes()) return;
  for (const double turn : {0.01, 0.1, 0.3, 0.9, 2.0}) {
    const auto z = std::polar(1.0, turn);
    const auto all = at(z);
    const double largest = all.cwiseAbs().maxCoeff();
    for (int row = 0; by_modes() && row < all.rows(); ++row)
      for (int column = 0; by_modes() && column < all.cols(); ++column)
        if (!(std::abs(at(z, row, column) - all(row, column)) <= kMostError * largest)) poles_.resize(0);
  }
}

void StepResponse::find_modes(const LinearStep& step, const Eigen::MatrixXd& c,
                              const std::vector<StepMode>& modes) {
  // J; poles at 0 come out as up to eps^(1/J), others lose J log10(1/|p|) digits.
  constexpr int kInARow = 5;
  constexpr double kZero = 2e-3, kLeastPole = 0.05;
  // The reciprocal condition of V is the share of the digits that are lost.
  constexpr double kLeastCondition = 1e-7;
  const auto n = step.a.rows();
  std::vector<const StepMode*> kept;
  for (const auto& mode : modes) {
    if (std::abs(mode.pole) > kZero) kept.push_back(&mode);
    if (std::abs(mode.pole) > kZero && std::abs(mode.pole) < kLeastPole) return;
  }
  const auto count = static_cast<Eigen::Index>(kept.size());
  if (count == 0 || step.b.cols() == 0 || c.rows() == 0) return;
  Eigen::MatrixXcd v(n, count);
  Eigen::ArrayXcd poles(count);
  for (Eigen::Index k = 0; k < count; ++k) {
    v.col(k) = kept[static_cast<std::size_t>(k)]->shape.normalized();
    poles[k] = kept[static_cast<std::size_t>(k)]->pole;
  }
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXcd> qr(v);
  const auto diagonal = qr.matrixR().diagonal().cwiseAbs();
  if (diagonal.minCoeff() < kLeastCondition * diagonal.maxCoeff()) return;
  std::vector<Eigen::MatrixXd> powers{step.b};
  for (int j = 0; j < kInARow; ++j) powers.emplace_back(step.a * powers.back());
  into_ = qr.solve(powers.back().cast<std::complex<double>>());
  into_.array().colwise() /= poles.pow(kInARow);
  const Eigen::MatrixXcd seen = c.cast<std::complex<double>>() * v;
  Eigen::MatrixXcd now = into_;
  for (int j = 0; j < kInARow; ++j) {
    at_once_.emplace_back(c * powers[static_cast<std::size_t>(j)] - (seen * now).real());
    now.array().colwise() *= poles;
  }
  out_ = seen.transpose();
  poles_ = poles;
}

/// Reciprocals by hand: those of the language look after infinities, which takes most of the time.
std::complex<double> StepResponse::at(std::complex<double> z, int output, int input) const {
  const auto real = z.real() - poles_.real();
  const auto imaginary = z.imag() - poles_.imag();
  const auto square = real.square() + imaginary.square();
  const auto in = into_.col(input).array(), out = out_.col(output).array();
  const auto share_real = in.real() * out.real() - in.imag() * out.imag();
  const auto share_imaginary = in.real() * out.imag() + in.imag() * out.real();
  std::complex<double> sum{((share_real * real + share_imaginary * imaginary) / square).sum(),
                           ((share_imaginary * real - share_real * imaginary) / square).sum()};
  const auto delay = 1.0 / z;
  std::complex<double> last = 0.0;
  for (auto c = at_once_.rbegin(); c != at_once_.rend(); ++c) last = ((*c)(output, input) + last) * delay;
  return sum + last;
}

/// Elimination of the one diagonal below the main one, with the larger of two rows on top.
Eigen::MatrixXcd StepResponse::at(std::complex<double> z) const {
  const auto n = minus_h_.rows();
  Rows m = minus_h_;
  Eigen::MatrixXcd x = b_;
  m.diagonal().array() += z;
  for (Eigen::Index i = 0; i + 1 < n; ++i) {
    if (std::norm(m(i + 1, i)) > std::norm(m(i, i))) {
      m.row(i).tail(n - i).swap(m.row(i + 1).tail(n - i));
      x.row(i).swap(x.row(i + 1));
    }
    const auto share = m(i + 1, i) / m(i, i);
    m.row(i + 1).tail(n - i) -= share * m.row(i).tail(n - i);
    x.row(i + 1) -= share * x.row(i);
  }
  for (Eigen::Index i = n - 1; i >= 0; --i)
    for (auto column : x.colwise()) {
      const auto known = m.row(i).tail(n - 1 - i).transpose().cwiseProduct(column.tail(n - 1 - i)).sum();
      column[i] = (column[i] - known) / m(i, i);
    }
  return c_ * x;
}

// ---- the rate that it needs

Result<double> radius_of(const NetworkElements& elements, int signals, Hertz rate, Solver solver) {
  const auto network = Network::make(elements, signals, rate, solver, 1);
  if (!network) return tl::unexpected(network.error());
  return state_size(elements, signals) > kMostLinearised
             ? radius_by_running(*network, elements, signals)
             : spectral_radius(linear_step(*network, elements, signals).a);
}

std::optional<Hertz> least_rate(const NetworkElements& elements, int signals, Solver solver) {
  constexpr double kLowest = 100.0, kHighest = 1e8;
  const auto stable_at = [&](double rate) {
    const auto radius = radius_of(elements, signals, Hertz{rate}, solver);
    return radius && *radius <= 1.0 + kRoundOfRadius;
  };
  if (stable_at(kLowest)) return std::nullopt;
  double low = kLowest, high = kLowest;
  while (!stable_at(high)) {
    if (high > kHighest) return Hertz{std::numeric_limits<double>::infinity()};
    low = high;
    high *= 2.0;
  }
  while (high > 1.001 * low) (stable_at(std::sqrt(low * high)) ? high : low) = std::sqrt(low * high);
  return Hertz{high};
}

}  // namespace tactus
