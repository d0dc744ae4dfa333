#include <Eigen/Geometry>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <numbers>

#include "engine/physics/linearised.h"
#include "engine/physics/network.h"

using namespace tactus;

// Bonds of several axes: springs along the line between two bodies, wherever they are.
namespace {

using Vector = Eigen::Vector3d;
constexpr double kRate = 48e3;

int add_body(NetworkElements& elements, Point::Kind kind, double mass, const Vector& at,
             const Vector& velocity, int axes) {
  const int first = static_cast<int>(elements.points.size());
  for (int a = 0; a < axes; ++a) elements.points.push_back({kind, mass, at[a], velocity[a], {}});
  return first;
}
int add_particle(NetworkElements& elements, double mass, const Vector& at,
                 const Vector& velocity = Vector::Zero(), int axes = 3) {
  return add_body(elements, Point::Kind::Mass, mass, at, velocity, axes);
}
int add_anchor(NetworkElements& elements, const Vector& at, int axes = 3) {
  return add_body(elements, Point::Kind::Ground, 0.0, at, Vector::Zero(), axes);
}
void add_line(NetworkElements& elements, int lower, int upper, double stiffness, double rest, int axes = 3,
              double damping = 0.0) {
  elements.bonds.push_back({.lower = lower,
                            .upper = upper,
                            .law = std::make_shared<LinearBond>(stiffness),
                            .damping = damping,
                            .axes = axes,
                            .rest = rest});
}

Vector place(const Network& network, const NetworkState& state, int first, int axes = 3) {
  Vector at = Vector::Zero();
  for (int a = 0; a < axes; ++a) at[a] = network.position(state, first + a);
  return at;
}
Vector speed(const Network& network, const NetworkState& state, int first) {
  return {network.velocity(state, first), network.velocity(state, first + 1),
          network.velocity(state, first + 2)};
}

Network network_of(const NetworkElements& elements, Solver solver, int signals = 0) {
  return Network::make(elements, signals, Hertz{kRate}, solver, 1).value();
}

/// Seconds between upward passages of a coordinate through 0.
double period_of(const Network& network, int point, int frames, const double* inputs = nullptr) {
  auto state = network.initial_state();
  double before = network.position(state, point), first = -1.0, last = -1.0;
  int count = -1;
  for (int n = 1; n <= frames; ++n) {
    network.step(state, inputs);
    const double now = network.position(state, point);
    if (before < 0.0 && now >= 0.0) {
      last = n - now / (now - before);
      if (++count == 0) first = last;
    }
    before = now;
  }
  REQUIRE(count > 0);
  return (last - first) / (count * kRate);
}

/// Three bodies of different masses that fly and tumble, joined by stretched springs.
struct Triangle {
  explicit Triangle(const Eigen::Matrix3d& turned = Eigen::Matrix3d::Identity()) {
    const Vector places[] = {{0, 0, 0}, {0.1, 0.01, 0}, {0.03, 0.09, 0.02}};
    const Vector velocities[] = {{0.3, 0, 0.5}, {0, 1.5, -0.4}, {-0.8, 0.2, 0.3}};
    const double masses[] = {0.02, 0.05, 0.01};
    for (int i = 0; i < 3; ++i)
      bodies[i] = add_particle(elements, masses[i], turned * places[i], turned * velocities[i]);
    for (int i = 0; i < 3; ++i)
      add_line(elements, bodies[i], bodies[(i + 1) % 3], 2000.0 * (i + 1),
               0.9 * (places[i] - places[(i + 1) % 3]).norm());
  }
  NetworkElements elements;
  int bodies[3] = {};
};

}  // namespace

TEST_CASE("lines: a pendulum on a stiff spring has the period of the elliptic integral", "[physics]") {
  // T = 4 sqrt(l / g) K(sin(amplitude / 2)); the cord of 1 MN/m gives by less than 3 mg/k = 3 um.
  const double l = 0.3, g = 9.81, mass = 0.1, stiffness = 1e6;
  const double amplitude = GENERATE(0.1, 1.0, 2.0);
  const auto solver =
      GENERATE(Solver::Passive, Solver::Implicit, Solver::Exact, Solver::Explicit, Solver::Reference);
  NetworkElements elements;
  const int hook = add_anchor(elements, Vector::Zero(), 2);
  const int bob = add_particle(elements, mass, {l * std::sin(amplitude), -l * std::cos(amplitude), 0.0},
                               Vector::Zero(), 2);
  add_line(elements, hook, bob, stiffness, l, 2);
  elements.forces.push_back({bob + 1, {0, {}}});
  const double weight = -mass * g;
  const double period = period_of(network_of(elements, solver, 1), bob, 6 * 48000, &weight);
  // 4 sqrt(l / g) K(sin(amplitude / 2)), the elliptic integral K by its arithmetic-geometric mean.
  double a = 1.0, b = std::cos(0.5 * amplitude);
  for (int i = 0; i < 6; ++i) {
    const double mean = 0.5 * (a + b);
    b = std::sqrt(a * b);
    a = mean;
  }
  const double expected = 2.0 * std::numbers::pi * std::sqrt(l / g) / a;
  CHECK(period == Approx(expected).epsilon(3.0 * weight / (-stiffness * l) + 2e-6));
}

TEST_CASE("lines: a body between two unstretched springs has a cubic restoring force", "[physics]") {
  // F = -2 k y (1 - L / sqrt(L^2 + y^2)) = -k y^3 / L^2 (1 - 3/4 (y/L)^2 + ...), so that
  // T = 7.4163 sqrt(m L^2 / k) / A, longer by less than 3/8 (A / L)^2.
  const double length = 0.1, stiffness = 5e4, mass = 1e-3, amplitude = 2e-3;
  const auto solver = GENERATE(Solver::Passive, Solver::Implicit, Solver::Exact, Solver::Explicit);
  NetworkElements elements;
  const int body = add_particle(elements, mass, {0, amplitude, 0}, Vector::Zero(), 2);
  for (const double side : {-length, length})
    add_line(elements, add_anchor(elements, {side, 0, 0}, 2), body, stiffness, length, 2);
  const double expected = 7.416299 * length * std::sqrt(mass / stiffness) / amplitude;
  const double period = period_of(network_of(elements, solver), body + 1, 48000);
  CHECK(period / expected - 1.0 > 0.0);
  CHECK(period / expected - 1.0 < 0.375 * std::pow(amplitude / length, 2));
}

TEST_CASE("lines: tension makes a transverse resonance, of the lines and of their linear form", "[physics]") {
  // f = sqrt(2 T / (m L)) / 2 pi; at an amplitude of 1e-5 L nothing else matters.
  const double length = 0.1, stiffness = 5e3, mass = 1e-3, tension = 20.0, amplitude = 1e-6;
  const double expected = 2.0 * std::numbers::pi / std::sqrt(2.0 * tension / (mass * length));
  const bool linear = GENERATE(false, true);
  const auto solver =
      GENERATE(Solver::Passive, Solver::Implicit, Solver::Exact, Solver::Explicit, Solver::Reference);
  NetworkElements elements;
  const int body = add_particle(elements, mass, {0, 0, amplitude});
  std::vector<double> places{0, 0, 0};
  for (const double side : {-length, length}) {
    add_line(elements, add_anchor(elements, {side, 0, 0}), body, stiffness, length - tension / stiffness);
    places.insert(places.end(), {side, 0, 0});
  }
  if (linear) {
    for (const auto& bond : elements.bonds)
      for (const auto& spring : line_springs(bond, places)) elements.springs.push_back(spring);
    elements.bonds.clear();
  }
  // (w k)^2 / 12 at most, w k = 0.013.
  CHECK(period_of(network_of(elements, solver), body + 2, 24000) == Approx(expected).epsilon(2e-5));
}

TEST_CASE("lines: the tangent of a stretched line has its stiffness along it and its tension across",
          "[physics]") {
  // One body between two oblique springs of direction n: w^2 m = 2 k along n, 2 T / L across it, twice.
  const double stiffness = 1000.0, length = 0.2, tension = 30.0, mass = 0.05;
  const Vector n = Vector{1.0, 2.0, -0.5}.normalized();
  NetworkElements elements;
  const int body = add_particle(elements, mass, Vector::Zero());
  for (const double side : {-length, length})
    add_line(elements, add_anchor(elements, side * n), body, stiffness, length - tension / stiffness);
  const auto linear = tangent(elements, {});
  const auto solver = GENERATE(Solver::Passive, Solver::Implicit, Solver::Exact);
  const auto found = modes(linear_step(network_of(linear, solver), linear, 0).a);
  std::vector<double> squares;
  for (const auto& mode : found)
    if (std::abs(mode.pole) > 0.5 && std::arg(mode.pole) > 0.0)
      squares.push_back(std::pow(std::arg(mode.pole) * kRate, 2));
  std::sort(squares.begin(), squares.end());
  REQUIRE(squares.size() == 3);
  CHECK(squares[0] == Approx(2.0 * tension / length / mass).epsilon(1e-4));
  CHECK(squares[1] == Approx(2.0 * tension / length / mass).epsilon(1e-4));
  CHECK(squares[2] == Approx(2.0 * stiffness / mass).epsilon(1e-4));
}

TEST_CASE("lines: free bodies keep energy, momentum and angular momentum", "[physics]") {
  const auto solver = GENERATE(Solver::Passive, Solver::Implicit, Solver::Exact);
  const Triangle triangle;
  const auto network = network_of(triangle.elements, solver);
  auto state = network.initial_state();
  // With the mean velocity of a step and the place at its end the discrete motion keeps it exactly.
  const auto momenta = [&](Vector& linear, Vector& angular, const Vector* before) {
    linear = angular = Vector::Zero();
    for (int i = 0; i < 3; ++i) {
      const auto first = triangle.bodies[i];
      const double mass = triangle.elements.points[index(first)].mass;
      const Vector at = place(network, state, first);
      const Vector v =
          solver == Solver::Exact ? speed(network, state, first) : Vector{(at - before[i]) * kRate};
      linear += mass * v;
      angular += mass * at.cross(v);
    }
  };
  Vector before[3], linear, angular, first_linear, first_angular;
  double energy = 0.0, worst = 0.0;
  for (int n = 0; n < 200'000; ++n) {
    for (int i = 0; i < 3; ++i) before[i] = place(network, state, triangle.bodies[i]);
    network.step(state, nullptr);
    momenta(linear, angular, before);
    if (n == 0) energy = network.energy(state), first_linear = linear, first_angular = angular;
    worst = std::max({worst, std::abs(network.energy(state) / energy - 1.0),
                      (linear - first_linear).norm() / first_linear.norm(),
                      (angular - first_angular).norm() / first_angular.norm()});
  }
  // Rounding: 2e5 steps of some 1e-16, of velocities that are differences of places up to 2 m.
  CHECK(worst < 1e-7);
}

TEST_CASE("lines: energy stays over a million steps, and explicit steps keep it on average",
          "[physics][slow]") {
  const auto solver = GENERATE(Solver::Passive, Solver::Implicit, Solver::Exact, Solver::Explicit);
  NetworkElements elements;
  const int body = add_particle(elements, 1e-3, {0, 0.01, 0}, {0, 0, 0.7});
  for (const double side : {-0.1, 0.1})
    add_line(elements, add_anchor(elements, {side, 0, 0}), body, 5e3, 0.099);
  const auto network = network_of(elements, solver);
  auto state = network.initial_state();
  network.step(state, nullptr);
  const double start = network.energy(state);
  double worst = 0.0;
  for (int n = 0; n < 1'000'000; ++n) {
    network.step(state, nullptr);
    worst = std::max(worst, std::abs(network.energy(state) / start - 1.0));
  }
  // w k <= sqrt(2 * 5e3 / 1e-3) / 48e3 = 0.066; explicit steps show their energy with an error of half of it.
  CHECK(worst < (solver == Solver::Explicit ? 0.033 : 1e-9));
}

TEST_CASE("lines: a damper takes energy from the length only", "[physics]") {
  // Of two bodies that circle at their equilibrium distance the length does not change.
  const double stiffness = 2e3, rest = 0.1, mass = 0.02, omega = 50.0;
  const auto solver = GENERATE(Solver::Passive, Solver::Implicit, Solver::Exact, Solver::Explicit);
  const double distance = stiffness * rest / (stiffness - 0.5 * mass * omega * omega);
  NetworkElements elements;
  const int one = add_particle(elements, mass, {0.5 * distance, 0, 0}, {0, 0.5 * omega * distance, 0}, 2);
  const int other = add_particle(elements, mass, {-0.5 * distance, 0, 0}, {0, -0.5 * omega * distance, 0}, 2);
  add_line(elements, one, other, stiffness, rest, 2, 5.0);
  const auto network = network_of(elements, solver);
  auto state = network.initial_state();
  for (int n = 0; n < 48000; ++n) network.step(state, nullptr);
  const double left = (place(network, state, one, 2) - place(network, state, other, 2)).norm();
  // Explicit steps damp by the chord of the last step, which circling bodies shorten by w^2 d k / 2 a second.
  const double chord = 5.0 * omega * omega * distance / (2.0 * kRate) / stiffness;
  CHECK(left == Approx(distance).margin(solver == Solver::Explicit ? chord : 1e-6 * distance));
}

TEST_CASE("lines: a damped length swings and decays within the reported error", "[physics]") {
  // Of two bodies of mass m: w_0^2 = 2 k / m, decay c = z / m, w = sqrt(w_0^2 - c^2).
  const double mass = 0.02, rest = 0.1, stiffness = GENERATE(1e4, 1e6), damping = GENERATE(0.5, 5.0);
  const double decay = damping / mass, omega = std::sqrt(2.0 * stiffness / mass - decay * decay);
  NetworkElements elements;
  const int one = add_particle(elements, mass, {0.03, 0.04, 0}, Vector::Zero(), 2);
  const int other = add_particle(elements, mass, {-0.03, -0.04, 0}, Vector::Zero(), 2);
  add_line(elements, one, other, stiffness, 0.999 * rest, 2, damping);
  for (const auto& bounds : choose_solver(elements, Hertz{kRate}, 1).candidates) {
    INFO(static_cast<int>(bounds.solver));
    const auto network = network_of(elements, bounds.solver);
    auto state = network.initial_state();
    // Upward passages of the extension, and the highest value between them.
    std::vector<double> passages, peaks;
    double before = network.bond_distance(state, 0), peak = 0.0;
    for (int n = 1; passages.size() < 6; ++n) {
      network.step(state, nullptr);
      const double now = network.bond_distance(state, 0);
      if (before < 0.0 && now >= 0.0)
        passages.push_back(n - now / (now - before)), peaks.push_back(peak = 0.0);
      if (!peaks.empty()) peaks.back() = std::max(peaks.back(), now);
      before = now;
    }
    const double seconds = (passages[4] - passages[0]) / (4.0 * kRate);
    CHECK(std::abs(2.0 * std::numbers::pi / seconds / omega - 1.0) <= bounds.error + 1e-6);
    // Frames show a peak lower by up to (w k / 2)^2 / 2.
    const double seen = 0.125 * std::pow(omega / kRate, 2);
    const double found = std::log(peaks[0] / peaks[4]) / (4.0 * seconds);
    CHECK(std::abs(found / decay - 1.0) <= bounds.error + seen / (4.0 * seconds * decay) + 1e-4);
  }
}

TEST_CASE("lines: the rate at which two bodies circle is right within the reported error", "[physics]") {
  // k (d - L) = (m / 2) w^2 d. A spring of w_0 = sqrt(2 k / m) bounds w.
  const double mass = 0.02, rest = 0.1, omega = GENERATE(300.0, 3000.0);
  const double stiffness = 0.5 * mass * omega * omega * 1.5;
  const double distance = stiffness * rest / (stiffness - 0.5 * mass * omega * omega);
  NetworkElements elements;
  const Vector half{0.5 * distance, 0, 0}, v{0, 0.5 * omega * distance, 0};
  const int one = add_particle(elements, mass, half, v, 2),
            other = add_particle(elements, mass, -half, -v, 2);
  add_line(elements, one, other, stiffness, rest, 2);
  const auto choice = choose_solver(elements, Hertz{kRate}, 1);
  for (const auto& bounds : choice.candidates) {
    INFO(static_cast<int>(bounds.solver));
    REQUIRE(bounds.stable);
    const double period = period_of(network_of(elements, bounds.solver), one, 48000);
    CHECK(std::abs(period * omega / (2.0 * std::numbers::pi) - 1.0) <= bounds.error + 1e-9);
  }
}

TEST_CASE("lines: a turned network makes the turned motion", "[physics]") {
  const auto solver = GENERATE(Solver::Passive, Solver::Implicit, Solver::Exact, Solver::Explicit);
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(0.7, Vector{0.3, -1.0, 0.5}.normalized()).toRotationMatrix();
  const Triangle straight, turned{turn};
  const auto one = network_of(straight.elements, solver), other = network_of(turned.elements, solver);
  auto state = one.initial_state(), turned_state = other.initial_state();
  double worst = 0.0;
  for (int n = 0; n < 2000; ++n) {
    one.step(state, nullptr), other.step(turned_state, nullptr);
    for (const int body : straight.bodies)
      worst = std::max(worst, (turn * place(one, state, body) - place(other, turned_state, body)).norm());
  }
  CHECK(worst < 1e-12);
}

TEST_CASE("lines: the linear form of a turned network makes the turned motion", "[physics]") {
  const auto solver = GENERATE(Solver::Passive, Solver::Implicit, Solver::Exact, Solver::Explicit);
  const auto path = [&](const Eigen::Matrix3d& turn) {
    NetworkElements elements;
    const int body = add_particle(elements, 0.01, Vector::Zero(), turn * Vector{0.1, 0.2, -0.3});
    const int hook = add_anchor(elements, turn * Vector{0.1, 0, 0});
    const int frame = add_anchor(elements, turn * Vector{0, 0.1, 0.05});
    std::vector<double> places;
    for (const auto& point : elements.points) places.push_back(point.position);
    add_line(elements, hook, body, 3e3, 0.09, 3, 0.5), add_line(elements, frame, body, 1e3, 0.1, 3, 2e3);
    for (const auto& bond : elements.bonds)
      for (const auto& spring : line_springs(bond, places)) elements.springs.push_back(spring);
    elements.bonds.clear();
    const auto network = network_of(elements, solver);
    auto state = network.initial_state();
    for (int n = 0; n < 2000; ++n) network.step(state, nullptr);
    return place(network, state, body);
  };
  if (solver == Solver::Explicit) return;  // not stable with a damper that stops the body within a step
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(0.7, Vector{0.3, -1.0, 0.5}.normalized()).toRotationMatrix();
  CHECK((path(turn) - turn * path(Eigen::Matrix3d::Identity())).norm() < 1e-12);
}

TEST_CASE("lines: all solvers converge to the reference with the square of the step", "[physics]") {
  const auto solver = GENERATE(Solver::Passive, Solver::Implicit, Solver::Exact, Solver::Explicit);
  const Triangle triangle;
  const auto end = [&](Solver of, int oversample) {
    const auto network = Network::make(triangle.elements, 0, Hertz{kRate}, of, oversample).value();
    auto state = network.initial_state();
    for (int n = 0; n < 2400; ++n) network.step(state, nullptr);
    return place(network, state, triangle.bodies[2]);
  };
  const auto truth = end(Solver::Reference, 1);
  const double coarse = (end(solver, 1) - truth).norm(), fine = (end(solver, 2) - truth).norm();
  CHECK(coarse / fine == Approx(4.0).epsilon(0.1));
  CHECK(fine < 1e-5);
}
