#include <array>
#include <catch2/catch.hpp>
#include <cmath>

#include "engine/physics/linearised.h"
#include "tests/support/error_summary.h"

using namespace tactus;

namespace {

Point mass(double kilogram, double position = 0.0, double velocity = 0.0) {
  return {Point::Kind::Mass, kilogram, position, velocity, {}};
}
Point ground() { return {Point::Kind::Ground, 0, 0, 0, {}}; }

using Matrix = std::array<std::array<long double, 4>, 4>;

Matrix product(const Matrix& a, const Matrix& b) {
  Matrix c{};
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t j = 0; j < 4; ++j)
      for (std::size_t l = 0; l < 4; ++l) c[i][j] += a[i][l] * b[l][j];
  return c;
}

Matrix matrix(const double (&rows)[4][4]) {
  Matrix all{};
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t j = 0; j < 4; ++j) all[i][j] = static_cast<long double>(rows[i][j]);
  return all;
}

/// exp(A t): the series for t / 2^20, squared twenty times.
Matrix exponential(Matrix a, long double t) {
  for (auto& row : a)
    for (auto& x : row) x *= t / 1048576.0L;
  Matrix sum{}, term{};
  for (std::size_t i = 0; i < 4; ++i) sum[i][i] = term[i][i] = 1.0L;
  for (int order = 1; order < 12; ++order) {
    term = product(term, a);
    for (std::size_t i = 0; i < 4; ++i)
      for (std::size_t j = 0; j < 4; ++j) term[i][j] /= order, sum[i][j] += term[i][j];
  }
  for (int i = 0; i < 20; ++i) sum = product(sum, sum);
  return sum;
}

}  // namespace

TEST_CASE("exact: the step of a woofer is that of its matrix exponential", "[physics]") {
  // x = (q, v, i):  m v' = Bl i - K q - R v,  L i' = V - Re i - Bl v;  V = 10 V from 0 on.
  const double m = 0.035, k = 1000.0, r = 1.2, bl = 6.0, re = 6.5, l = 0.8e-3, volt = 10.0;
  NetworkElements elements;
  elements.points = {mass(m), ground()};
  elements.springs = {{1, 0, k, r, 0.0}};
  elements.coils = {{0, -1, bl, re, l, {0, {}}}};
  const auto network = Network::make(elements, 1, 48_kHz, Solver::Exact, 1).value();
  auto state = network.initial_state();
  const auto rates =
      matrix({{0, 1, 0, 0}, {-k / m, -r / m, bl / m, 0}, {0, -bl / l, -re / l, volt / l}, {0, 0, 0, 0}});
  const double scale = bl * volt / re / k;  // where the cone comes to rest
  for (int n = 1; n <= 4800; ++n) {
    network.step(state, &volt);
    if (n % 480 != 0) continue;
    const auto power = exponential(rates, n / 48e3L);
    const auto expected = [&](std::size_t i) { return static_cast<double>(power[i][3]); };
    CHECK(network.position(state, 0) == Approx(expected(0)).margin(1e-9 * scale).epsilon(0));
    CHECK(network.velocity(state, 0) == Approx(expected(1)).margin(1e-9).epsilon(0));
    CHECK(network.current(state, 0) == Approx(expected(2)).margin(1e-9).epsilon(0));
  }
}

TEST_CASE("exact: an oscillator of any stiffness gives its analytic samples", "[physics]") {
  // Far above half the rate too: the frames are samples of the true motion.
  const double rate = 1000.0, m = 0.2, damping = 0.4, stiffness = GENERATE(10.0, 1e4, 1e8, 1e12);
  NetworkElements elements;
  elements.points = {mass(m, 1.0), ground()};
  elements.springs = {{1, 0, stiffness, damping, 0.0}};
  const auto network = Network::make(elements, 0, Hertz{rate}, Solver::Exact, 1).value();
  auto state = network.initial_state();
  const double decay = damping / (2 * m), w = std::sqrt(stiffness / m - decay * decay);
  for (int n = 0; n < 1000; ++n) {
    const double t = n / rate;
    const double x = std::exp(-decay * t) * (std::cos(w * t) + decay / w * std::sin(w * t));
    // The phase w t itself is known to 1e-16 of its size only.
    REQUIRE(network.position(state, 0) == Approx(x).margin(1e-11 + 1e-14 * w * t).epsilon(0));
    network.step(state, nullptr);
  }
}

TEST_CASE("exact: a mass on a driven point moves as its transfer function between the frames' corners",
          "[physics]") {
  // A ramp: x = V (t - sin(w t) / w) for an undamped mass whose other end goes with V from 0 on.
  const double rate = 2000.0, k = 500.0, m = 0.1, speed = 0.3, w = std::sqrt(k / m);
  NetworkElements elements;
  elements.points = {mass(m), {Point::Kind::Motion, 0, 0, 0, {0, {}}}};
  elements.springs = {{1, 0, k, 0.0, 0.0}};
  const auto network = Network::make(elements, 1, Hertz{rate}, Solver::Exact, GENERATE(1, 4)).value();
  auto state = network.initial_state();
  for (int n = 0; n < 2000; ++n) {
    const double place = speed * n / rate;  // at frame n it goes there until frame n + 1
    network.step(state, &place);
    const double t = n / rate;
    REQUIRE(network.position(state, 0) == Approx(speed * (t - std::sin(w * t) / w)).margin(1e-11));
  }
}

TEST_CASE("exact: groups of masses are stepped apart from each other", "[physics]") {
  // Ten pairs that only touch: ten small matrices, not a large one.
  NetworkElements elements;
  for (int i = 0; i < 10; ++i) {
    elements.points.push_back(mass(0.01, 0.001 * i));
    elements.points.push_back(mass(0.02, 0.001 * i));
    elements.springs.push_back({2 * i, 2 * i + 1, 1e4, 0.1, 0.0});
    if (i > 0)
      elements.contacts.push_back({.lower = 2 * i - 1, .upper = 2 * i, .stiffness = 1e6, .restitution = {}});
  }
  const auto network = Network::make(elements, 0, 48_kHz, Solver::Exact, 1).value();
  CHECK(network.network_solver().cost().step < 10 * 4 * 4 + 100);
  // Each pair may fly away, none grows.
  CHECK(radius_of(tangent(elements, {}), 0, 48_kHz, Solver::Exact).value() == Approx(1.0).epsilon(1e-6));
}

TEST_CASE("exact: too many masses are refused with what to do", "[physics]") {
  NetworkElements elements;
  for (int i = 0; i < 200; ++i) elements.points.push_back(mass(0.01));
  for (int i = 1; i < 200; ++i) elements.springs.push_back({i - 1, i, 1e4, 0.0, 0.0});
  const auto network = Network::make(elements, 0, 48_kHz, Solver::Exact, 1);
  REQUIRE_FALSE(network);
  CHECK(test::summary(network) == R"(OutOfRange 200 128 solver "passive" "implicit")");
}
