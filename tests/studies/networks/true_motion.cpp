#include "tests/studies/networks/true_motion.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "engine/core/index.h"

namespace tactus::study {
namespace {

using test::RandomNetwork;

using Real = long double;
using Vector = Eigen::Matrix<Real, Eigen::Dynamic, 1>;
using Matrix = Eigen::Matrix<Real, Eigen::Dynamic, Eigen::Dynamic>;

constexpr int kMostSteps = 1'000'000;
constexpr Real kTolerance = 1e-12L;

/// Unknowns: positions and speeds of all points, then the currents.
class Equations {
 public:
  explicit Equations(const NetworkElements& elements)
      : elements_(elements), points_(std::ssize(elements.points)) {}

  Vector start() const {
    Vector y = Vector::Zero(2 * points_ + std::ssize(elements_.coils));
    for (Eigen::Index i = 0; i < points_; ++i) {
      y[i] = at(i).position;
      y[points_ + i] = at(i).velocity;
    }
    return y;
  }

  /// The loss of each contact is set where it closes.
  void close_contacts(const Vector& y) {
    loss_.resize(elements_.contacts.size());
    closed_.resize(elements_.contacts.size());
    for (std::size_t i = 0; i < loss_.size(); ++i) {
      const auto& c = elements_.contacts[i];
      const bool now = depth(y, c) > 0;
      if (now && !closed_[i]) loss_[i] = loss_of(c, approach(y, c));
      closed_[i] = now;
    }
  }

  /// The share of a step from `before` after which a contact with restitution closes, whose loss its speed
  /// there sets; 1: none does.
  Real until_closed(const Vector& before, const Vector& after) const {
    constexpr Real kTouch_m = 1e-14L;
    Real share = 1;
    for (std::size_t i = 0; i < closed_.size(); ++i) {
      const auto& c = elements_.contacts[i];
      const Real from = depth(before, c), to = depth(after, c);
      if (c.restitution && !closed_[i] && to > kTouch_m) share = std::min(share, from / (from - to));
    }
    return share;
  }

  Vector rates(const Vector& y, Real signal) const {
    Vector d = Vector::Zero(y.size());
    d.head(points_) = y.segment(points_, points_);
    auto force = d.segment(points_, points_);
    const auto push = [&](int lower, int upper, Real by) { force[lower] -= by, force[upper] += by; };
    for (const auto& s : elements_.springs)
      push(s.lower, s.upper,
           -(s.stiffness * (y[s.upper] - y[s.lower] - s.rest) +
             s.damping * (speed(y, s.upper) - speed(y, s.lower))));
    for (std::size_t i = 0; i < elements_.contacts.size(); ++i)
      push(elements_.contacts[i].lower, elements_.contacts[i].upper, pressure(y, i));
    for (const auto& b : elements_.bonds)
      push(b.lower, b.upper,
           b.law->largest_stiffness() * (y[b.lower] - y[b.upper]) +
               b.damping * (speed(y, b.lower) - speed(y, b.upper)));
    for (const auto& f : elements_.forces) force[f.on] += signal;
    for (const auto& p : elements_.ports) force[p.on] -= p.impedance * speed(y, p.on);
    for (std::size_t i = 0; i < elements_.coils.size(); ++i) {
      const auto& c = elements_.coils[i];
      const auto row = 2 * points_ + static_cast<Eigen::Index>(i);
      const Real back = c.force_factor * (speed(y, c.on) - speed(y, c.against));
      const Real current = c.inductance > 0 ? y[row] : -back / c.resistance;
      if (c.inductance > 0) d[row] = (-c.resistance * current - back) / c.inductance;
      force[c.on] += c.force_factor * current;
      force[c.against] -= c.force_factor * current;
    }
    for (Eigen::Index i = 0; i < points_; ++i)
      force[i] = at(i).kind == Point::Kind::Mass ? force[i] / at(i).mass : 0;
    return d;
  }

  /// Units in which positions are about as large as speeds.
  Vector units(const Vector& y) const {
    Real fastest = 1;
    for (const auto& s : elements_.springs)
      for (const int end : {s.lower, s.upper})
        if (at(end).kind == Point::Kind::Mass)
          fastest = std::max<Real>(fastest, std::sqrt(Real{s.stiffness} / at(end).mass));
    Vector unit = Vector::Ones(y.size() + 2);
    unit.segment(points_, points_).setConstant(fastest);
    return unit;
  }

 private:
  const Point& at(Eigen::Index i) const { return elements_.points[static_cast<std::size_t>(i)]; }
  Real speed(const Vector& y, int point) const { return y[points_ + point]; }
  static Real depth(const Vector& y, const Contact& c) { return y[c.lower] - y[c.upper] + c.offset; }
  Real approach(const Vector& y, const Contact& c) const { return speed(y, c.lower) - speed(y, c.upper); }

  Real pressure(const Vector& y, std::size_t i) const {
    const auto& c = elements_.contacts[i];
    const Real n = depth(y, c), v = approach(y, c);
    if (n <= 0) return 0;
    const Real loss = closed_[i] ? loss_[i] : loss_of(c, v);
    return std::max<Real>(0, c.stiffness * std::pow(n, Real{c.exponent}) * (1 + loss * v));
  }

  /// r of  r v - ln(1 + r v) = -r e v - ln(1 - r e v), by bisection.
  static Real loss_of(const Contact& c, Real v) {
    if (!c.restitution) return c.loss;
    const Real e = *c.restitution;
    Real low = 0, high = 1 / e;
    for (int i = 0; i < 200; ++i) {
      const Real x = (low + high) / 2;
      const Real more = x - std::log1p(x) + e * x + std::log1p(-e * x);
      (more > 0 ? low : high) = x;
    }
    return low / std::max<Real>(v, 1e-4L);
  }

  const NetworkElements& elements_;
  Eigen::Index points_;
  std::vector<Real> loss_;
  std::vector<char> closed_;
};

// 113 bits: what squaring loses beside fast decays, up to 10^17 times the rounding, is then nothing.
__extension__ using Quad = __float128;

/// Row by row.
struct QuadMatrix {
  explicit QuadMatrix(Eigen::Index rows) : n(static_cast<std::size_t>(rows)), entries(n * n) {}
  Quad& operator()(std::size_t row, std::size_t column) { return entries[row * n + column]; }
  Quad operator()(std::size_t row, std::size_t column) const { return entries[row * n + column]; }

  friend QuadMatrix operator*(const QuadMatrix& a, const QuadMatrix& b) {
    QuadMatrix c(static_cast<Eigen::Index>(a.n));
    for (std::size_t i = 0; i < a.n; ++i)
      for (std::size_t k = 0; k < a.n; ++k)
        if (const Quad by = a(i, k); by != 0)
          for (std::size_t j = 0; j < a.n; ++j) c(i, j) += by * b(k, j);
    return c;
  }

  std::size_t n;
  std::vector<Quad> entries;
};

/// e^A: the series in parts of norm below 1/2, squared.
QuadMatrix exponential(QuadMatrix a) {
  constexpr int kTerms = 26;
  double norm = 0.0;
  for (const auto& entry : a.entries) norm = std::max(norm, std::abs(static_cast<double>(entry)));
  const int squarings = std::max(0, 1 + std::ilogb(norm * static_cast<double>(a.n)) + 1);
  const Quad part = std::ldexp(1.0, -squarings);
  for (auto& entry : a.entries) entry *= part;
  QuadMatrix power = a;
  for (std::size_t i = 0; i < a.n; ++i)
    for (std::size_t j = 0; j < a.n; ++j) power(i, j) = Quad(i == j) + a(i, j) / kTerms;
  for (int term = kTerms - 1; term > 0; --term) {
    power = a * power;
    for (auto& entry : power.entries) entry /= term;
    for (std::size_t i = 0; i < a.n; ++i) power(i, i) += 1;
  }
  for (int i = 0; i < squarings; ++i) power = power * power;
  return power;
}

std::vector<double> solve_linear(const RandomNetwork& network, Equations& equations) {
  Vector start = equations.start();
  equations.close_contacts(start);
  const auto n = start.size();
  const Vector unit = equations.units(start);
  // Two more unknowns: the signal and 1.
  Matrix a = Matrix::Zero(n + 2, n + 2);
  const Vector constant = equations.rates(Vector::Zero(n), 0);
  a.col(n + 1).head(n) = constant;
  a.col(n).head(n) = equations.rates(Vector::Zero(n), 1) - constant;
  for (Eigen::Index j = 0; j < n; ++j) a.col(j).head(n) = equations.rates(Vector::Unit(n, j), 0) - constant;
  QuadMatrix rates(n + 2);
  const Quad frame_s = 1 / Quad(network.rate.value);
  for (Eigen::Index i = 0; i < n + 2; ++i)
    for (Eigen::Index j = 0; j < n + 2; ++j)
      rates(static_cast<std::size_t>(i), static_cast<std::size_t>(j)) = frame_s * a(i, j) * unit[j] / unit[i];
  const QuadMatrix step = exponential(std::move(rates));
  std::vector<Quad> y(step.n), next(step.n);
  for (Eigen::Index i = 0; i < n; ++i) y[static_cast<std::size_t>(i)] = start[i] / unit[i];
  std::vector<double> path{static_cast<double>(start[network.watched])};
  for (int frame = 0; frame < network.frames; ++frame) {
    y[step.n - 2] = network.signal(frame), y[step.n - 1] = 1;
    for (std::size_t i = 0; i < step.n; ++i) {
      next[i] = 0;
      for (std::size_t j = 0; j < step.n; ++j) next[i] += step(i, j) * y[j];
    }
    y.swap(next);
    path.push_back(static_cast<double>(y[index(network.watched)]));
  }
  return path;
}

std::optional<std::vector<double>> integrate(const RandomNetwork& network, Equations& equations) {
  static constexpr Real kA[6][6] = {
      {1.0L / 5},
      {3.0L / 40, 9.0L / 40},
      {44.0L / 45, -56.0L / 15, 32.0L / 9},
      {19372.0L / 6561, -25360.0L / 2187, 64448.0L / 6561, -212.0L / 729},
      {9017.0L / 3168, -355.0L / 33, 46732.0L / 5247, 49.0L / 176, -5103.0L / 18656},
      {35.0L / 384, 0, 500.0L / 1113, 125.0L / 192, -2187.0L / 6784, 11.0L / 84}};
  static constexpr Real kError[7] = {71.0L / 57600,      0,           -71.0L / 16695, 71.0L / 1920,
                                     -17253.0L / 339200, 22.0L / 525, -1.0L / 40};
  Vector y = equations.start(), largest = y.cwiseAbs();
  std::vector<double> path{static_cast<double>(y[network.watched])};
  const Real frame_s = 1 / Real{network.rate.value};
  Real advised = frame_s / 100;
  int steps = 0;
  for (int frame = 0; frame < network.frames; ++frame) {
    const Real signal = network.signal(frame);
    for (Real left = frame_s; left > 0;) {
      if (++steps > kMostSteps) return std::nullopt;
      equations.close_contacts(y);
      const Real h = std::min(advised, left);
      Vector slope[7], next = y;
      slope[0] = equations.rates(y, signal);
      for (int s = 0; s < 6; ++s) {
        next = y;
        for (int j = 0; j <= s; ++j) next += h * kA[s][j] * slope[j];
        slope[s + 1] = equations.rates(next, signal);
      }
      Real worst = 0;
      Vector difference = Vector::Zero(y.size());
      for (int s = 0; s < 7; ++s) difference += h * kError[s] * slope[s];
      for (Eigen::Index i = 0; i < y.size(); ++i)
        worst = std::max(worst, std::abs(difference[i]) / (kTolerance * std::max<Real>(largest[i], 1e-6L)));
      if (!(worst == worst)) return std::nullopt;
      advised = h * std::clamp<Real>(0.9L * std::pow(std::max<Real>(worst, 1e-30L), -0.2L), 0.2L, 4);
      if (worst > 1) continue;
      if (const Real share = equations.until_closed(y, next); share < 1) {
        advised = std::max(share * h, frame_s * 1e-15L);
        continue;
      }
      y = next;
      largest = largest.cwiseMax(y.cwiseAbs());
      left -= h;
    }
    path.push_back(static_cast<double>(y[network.watched]));
  }
  return path;
}

}  // namespace

bool may_slip(const NetworkElements& elements) {
  return !elements.frictions.empty() || std::ranges::any_of(elements.bonds, &Bond::slips);
}

std::optional<std::vector<double>> true_motion(const test::RandomNetwork& network) {
  const auto& elements = network.elements;
  if (may_slip(elements)) return std::nullopt;
  Equations equations(elements);
  if (elements.contacts.empty()) return solve_linear(network, equations);
  return integrate(network, equations);
}

}  // namespace tactus::study
