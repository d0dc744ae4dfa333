#include "engine/physics/network.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <complex>

#include "engine/core/units.h"
#include "engine/physics/linearised.h"

using namespace tactus;

namespace {

Point mass(double kilogram, double position = 0.0, double velocity = 0.0) {
  return {Point::Kind::Mass, kilogram, position, velocity, {}};
}
Point ground(double position = 0.0) { return {Point::Kind::Ground, 0, position, 0, {}}; }

/// Stick 0, cone 1, frame 2; signals: coil voltage 0, force on the stick 1.
NetworkElements drum() {
  NetworkElements elements;
  elements.points = {mass(0.0125, 0.02), mass(0.035), ground()};
  elements.springs = {{1, 2, 1000.0, 1.2, 0.0}};
  elements.contacts = {
      {.lower = 1, .upper = 0, .stiffness = 5e6, .exponent = 1.5, .loss = 0.15, .restitution = {}}};
  elements.coils = {{1, 2, 6.0, 6.5, 0.8e-3, {0, {}}}};
  elements.forces = {{0, {1, {}}}};
  return elements;
}

NetworkElements oscillator(double stiffness, double damping, Point point = mass(1.0, 1.0)) {
  NetworkElements elements;
  elements.points = {point, ground()};
  elements.springs = {{0, 1, stiffness, damping, 0.0}};
  return elements;
}

}  // namespace

TEST_CASE("network: a stick on a free cone leaves with (e m_c - m_s) / (m_s + m_c) of its speed",
          "[physics]") {
  const auto solver = GENERATE(Solver::Passive, Solver::Explicit, Solver::Implicit, Solver::Exact);
  auto elements = drum();
  elements.points[0] = mass(0.0125, 0.001, -1.0);
  elements.springs.clear();
  elements.coils.clear();
  const auto network = Network::make(elements, 2, 48_kHz, solver, 1).value();
  auto state = network.initial_state();
  const double inputs[] = {0.0, 0.0};
  bool touched = false;
  for (int open = 0; open < 3;) {
    network.step(state, inputs);
    touched = touched || network.indentation(state, 0) > 0.0;
    open = touched && network.indentation(state, 0) == 0.0 ? open + 1 : 0;
  }
  CHECK(network.velocity(state, 0) == Approx((0.909016 * 35 - 12.5) / 47.5).margin(1e-3));
}

TEST_CASE("network: the coil moves the cone as its transfer function says, hold included", "[physics]") {
  const auto solver = GENERATE(Solver::Passive, Solver::Explicit, Solver::Implicit, Solver::Exact);
  const auto frequency = GENERATE(5.0, 20.0, 26.9, 60.0, 200.0, 1000.0);
  // Backward differences of the velocity lag half a frame: the explicit solver is held to 3 degrees only.
  const double degrees = solver == Solver::Explicit ? 3.0 : 1.0;
  const double rate = 48e3, omega = 2 * kPi * frequency;
  const std::complex<double> j(0, 1), s = j * omega;
  const double bl = 6, r = 6.5, l = 0.8e-3, m = 0.035;
  const auto plant = bl / ((r + s * l) * (1000.0 + s * s * m + s * 1.2) + s * bl * bl);
  const auto hold = (1.0 - std::exp(-s / rate)) / (s / rate);

  const auto network = Network::make(drum(), 2, Hertz{rate}, solver, 1).value();
  auto state = network.initial_state();
  std::complex<double> measured = 0;
  const int settling = 48000;  // the slowest pole decays as exp(-t / 20 ms)
  const int frames = static_cast<int>(std::round(std::ceil(frequency / 4) * 4 / frequency * rate));
  for (int n = 0; n < settling + frames; ++n) {
    const auto turn = std::exp(s * (n / rate));
    if (n >= settling) measured += network.position(state, 1) * std::conj(turn) * 2.0 / double(frames);
    const double inputs[] = {turn.real(), 0.0};
    network.step(state, inputs);
  }
  const auto ratio = measured / (plant * hold);
  CHECK(20 * std::log10(std::abs(ratio)) == Approx(0).margin(0.1));
  CHECK(std::arg(ratio) * 180 / kPi == Approx(0).margin(degrees));
}

TEST_CASE("network: an explicit oscillator is stable up to K + 2Z = 4 and not beyond", "[physics]") {
  const double rate = 1000.0, z = GENERATE(0.1, 0.5, 1.0, 1.9);
  const auto radius = [&](double k) {
    return radius_of(oscillator(k * rate * rate, z * rate), 0, Hertz{rate}, Solver::Explicit).value();
  };
  CHECK(radius(4.0 - 2 * z - 1e-6) < 1.0);
  CHECK(radius(4.0 - 2 * z + 1e-6) > 1.0);
}

TEST_CASE("network: what is said to be stable decays, what is not grows", "[physics]") {
  const double rate = 1000.0;
  const auto end = [&](double k) {
    const auto network =
        Network::make(oscillator(k * rate * rate, 0.5 * rate), 0, Hertz{rate}, Solver::Explicit, 1).value();
    auto state = network.initial_state();
    for (int i = 0; i < 3000; ++i) network.step(state, nullptr);
    return std::abs(network.position(state, 0));
  };
  CHECK(end(2.99) < 1e-6);
  CHECK(end(3.01) > 1e6);
}

TEST_CASE("network: an explicit damped oscillator gives its analytic samples", "[physics]") {
  // Z = 1 - exp(-2 s T), K = 1 + exp(-2 s T) - 2 exp(-s T) cos(w T): poles at exp((-s +- j w) T) exactly.
  const double rate = 44100.0, decay = 50.0, omega = 2 * kPi * 440.0, t = 1 / rate;
  const double z = 1 - std::exp(-2 * decay * t);
  const double k = 1 + std::exp(-2 * decay * t) - 2 * std::exp(-decay * t) * std::cos(omega * t);
  const auto network =
      Network::make(oscillator(k * rate * rate, z * rate), 0, Hertz{rate}, Solver::Explicit, 1).value();
  auto state = network.initial_state();
  network.step(state, nullptr);
  // x(nT) = exp(-s nT) (cos(w nT) + b sin(w nT)), b from the second sample.
  const double b =
      (network.position(state, 0) * std::exp(decay * t) - std::cos(omega * t)) / std::sin(omega * t);
  for (int n = 1; n < 4000; ++n) {
    const double x = std::exp(-decay * n * t) * (std::cos(omega * n * t) + b * std::sin(omega * n * t));
    REQUIRE(network.position(state, 0) == Approx(x).margin(1e-10));
    network.step(state, nullptr);
  }
}

TEST_CASE("network: the modes of an explicit chain", "[physics]") {
  // f_j = (fs / pi) asin(sqrt(K) sin(j pi / (2 (N + 1)))); in the mode's shape every mass moves as cos(2 pi f
  // n / fs).
  const double rate = 44100.0, k = GENERATE(0.25, 1.0);
  const int mode = GENERATE(1, 4, 10), count = 10;
  const auto shape = [&](int i) { return std::sin((i + 1) * mode * kPi / (count + 1)); };
  NetworkElements elements;
  for (int i = 0; i < count; ++i) elements.points.push_back(mass(1.0, shape(i)));
  elements.points.push_back(ground());
  for (int i = 0; i <= count; ++i)
    elements.springs.push_back({i == 0 ? count : i - 1, i, k * rate * rate, 0.0, 0.0});
  const auto network = Network::make(elements, 0, Hertz{rate}, Solver::Explicit, 1).value();
  auto state = network.initial_state();
  const double f = rate / kPi * std::asin(std::sqrt(k) * std::sin(mode * kPi / (2.0 * (count + 1))));
  if (k == 1.0) CHECK(f == Approx(mode * rate / (2 * (count + 1))).epsilon(1e-12));  // exactly harmonic
  // From x[n-1] + x[n+1] = 2 cos(w T) x[n], at the first mass, where x[n] is largest.
  double before = network.position(state, 0), cosine = 0, largest = 0;
  network.step(state, nullptr);
  for (int n = 0; n < 200; ++n) {
    const double here = network.position(state, 0);
    network.step(state, nullptr);
    if (std::abs(here) > largest) {
      largest = std::abs(here);
      cosine = (before + network.position(state, 0)) / (2 * here);
    }
    before = here;
  }
  CHECK(rate / (2 * kPi) * std::acos(cosine) == Approx(f).epsilon(1e-9));
}

TEST_CASE("network: a long chain stored by diagonals does what a short one does", "[physics]") {
  // The fastest that anything can travel is one mass a step, so 40 masses at both ends cannot be
  // distinguished from 200.
  const auto run = [](int count) {
    NetworkElements elements;
    for (int i = 0; i < count; ++i) elements.points.push_back(mass(1.0 + 0.01 * (i % 7), i == 0 ? 1.0 : 0.0));
    for (int i = 1; i < count; ++i) elements.springs.push_back({i - 1, i, 0.3e6, 20.0, 0.0});
    const auto network = Network::make(elements, 0, 1_kHz, Solver::Explicit, 1).value();
    auto state = network.initial_state();
    for (int n = 0; n < 10; ++n) network.step(state, nullptr);
    return network.position(state, 5);
  };
  CHECK(run(12) == Approx(run(200)).epsilon(1e-12));
  CHECK(std::abs(run(12)) > 1e-6);
}

TEST_CASE("network: flight under a constant force is exact, from the first frame", "[physics]") {
  // A centred solver has no error on a parabola; position 1 m, speed 2 m/s, force -3 N on 0.5 kg.
  const auto solver = GENERATE(Solver::Passive, Solver::Explicit, Solver::Implicit, Solver::Exact);
  const auto oversample = GENERATE(1, 3);
  NetworkElements elements;
  elements.points = {mass(0.5, 1.0, 2.0)};
  elements.forces = {{0, {0, {}}}};
  const auto network = Network::make(elements, 1, 1_kHz, solver, oversample).value();
  auto state = network.initial_state();
  CHECK(network.velocity(state, 0) == Approx(2.0).epsilon(1e-12));
  const double force = -3.0;
  for (int n = 0; n < 1000; ++n) {
    const double t = n / 1000.0;
    REQUIRE(network.position(state, 0) == Approx(1.0 + 2.0 * t - 3.0 * t * t).margin(1e-11));
    if (n > 2) REQUIRE(network.velocity(state, 0) == Approx(2.0 - 6.0 * t).margin(1e-9));
    network.step(state, &force);
  }
}

TEST_CASE("network: too stiff springs are averaged by the passive solver, and stay stable", "[physics]") {
  const double rate = 1000.0, stiffness = 100.0 * rate * rate;
  const auto network = Network::make(oscillator(stiffness, 0.0), 0, Hertz{rate}, Solver::Passive, 1).value();
  CHECK(network.springs_averaged());
  auto state = network.initial_state();
  network.step(state, nullptr);
  const double start = network.energy(state);
  for (int n = 0; n < 10000; ++n) network.step(state, nullptr);
  CHECK(network.energy(state) == Approx(start).epsilon(1e-11));
  CHECK_FALSE(Network::make(oscillator(3.0 * rate * rate, 0.0), 0, Hertz{rate}, Solver::Passive, 1)
                  ->springs_averaged());
}

TEST_CASE("network: a driven point goes in straight lines, one frame later", "[physics]") {
  NetworkElements elements;
  elements.points = {{Point::Kind::Motion, 0, 0, 0, {0, {}}}};
  const auto network = Network::make(elements, 1, 1_kHz, Solver::Passive, GENERATE(1, 4)).value();
  auto state = network.initial_state();
  for (int n = 0; n < 10; ++n) {
    const double place = 3.0 + n;
    network.step(state, &place);
    CHECK(network.position(state, 0) == Approx(place).epsilon(1e-14));
    CHECK(network.velocity(state, 0) == Approx(n < 2 ? 0.0 : 1000.0).margin(n == 1 ? 1e4 : 1e-8));
  }
}

TEST_CASE("network: a hand is 3 dB down at its bandwidth and settled at the start", "[physics]") {
  const double rate = 8000.0, bandwidth = 8.0;
  NetworkElements elements;
  elements.points = {mass(0.01), {Point::Kind::Motion, 0, 0, 0, {0, Hertz{bandwidth}}}};
  elements.springs = {{0, 1}};
  elements.forces = {{0, {1, Hertz{bandwidth}}}};
  const auto network = Network::make(elements, 2, Hertz{rate}, Solver::Passive, 1).value();
  auto state = network.initial_state();
  std::complex<double> measured = 0;
  for (int n = 0; n < 10000; ++n) {
    const auto turn = std::polar(1.0, 2 * kPi * bandwidth * n / rate);
    const double inputs[] = {turn.real(), 1.0};
    network.step(state, inputs);
    if (n == 0) CHECK(network.position(state, 1) == Approx(1.0));
    if (n >= 2000) measured += network.position(state, 1) * std::conj(turn) / 4000.0;
  }
  CHECK(20 * std::log10(std::abs(measured)) == Approx(-3.01).margin(0.02));
  CHECK(network.applied_force(state, 0) == Approx(1.0));
}

TEST_CASE("network: the current of a blocked coil rises as 1 - exp(-R t / L)", "[physics]") {
  NetworkElements elements;
  elements.points = {ground()};
  elements.coils = {{0, -1, 6.0, 6.5, 0.8e-3, {0, {}}}};
  const auto network = Network::make(elements, 1, 48_kHz, Solver::Passive, 1).value();
  auto state = network.initial_state();
  const double voltage = 13.0;
  for (int n = 0; n < 100; ++n) {
    // The centred solver takes (1 - x/2) / (1 + x/2) for exp(-x), x = R k / L = 0.17: 0.04 % a step, 0.4 % at
    // half.
    CHECK(network.current(state, 0) == Approx(2.0 * (1 - std::exp(-6.5 / 0.8e-3 * n / 48e3))).margin(0.01));
    network.step(state, &voltage);
  }
}

TEST_CASE("network: without an inductance the current follows at once", "[physics]") {
  auto elements = drum();
  elements.coils[0].inductance = 0.0;
  const auto network = Network::make(elements, 2, 48_kHz, Solver::Passive, 1).value();
  auto state = network.initial_state();
  const double inputs[] = {6.5, 0.0};
  for (int n = 0; n < 2; ++n) network.step(state, inputs);
  CHECK(network.current(state, 0) == Approx(1.0).margin(0.02));
  for (int n = 0; n < 48000; ++n) network.step(state, inputs);
  CHECK(network.position(state, 1) == Approx(6e-3).epsilon(1e-6));  // Bl i / K
}

TEST_CASE("network: an inductance far below a step is none, for every solver", "[physics]") {
  const auto solver = GENERATE(Solver::Explicit, Solver::Passive, Solver::Implicit, Solver::Exact);
  const auto current = [&](double inductance) {
    auto elements = drum();
    elements.coils[0].inductance = inductance;
    const auto network = Network::make(elements, 2, 48_kHz, solver, 4).value();
    auto state = network.initial_state();
    const double inputs[] = {6.5, 0.0};
    std::vector<double> currents;
    for (int n = 0; n < 20; ++n) {
      currents.push_back(network.current(state, 0));
      network.step(state, inputs);
    }
    return currents;
  };
  CHECK(current(1e-30) == current(0.0));
  CHECK(current(1e-15) != current(0.0));
}

TEST_CASE("network: reset repeats the run bit for bit", "[physics]") {
  const auto network = Network::make(drum(), 2, 48_kHz, Solver::Passive, 2).value();
  auto state = network.initial_state();
  const auto run = [&] {
    for (int n = 0; n < 5000; ++n) {
      const double inputs[] = {n % 700 < 50 ? 10.0 : 0.0, -0.6};
      network.step(state, inputs);
    }
    return network.position(state, 0) + network.current(state, 0);
  };
  const double first = run();
  network.reset(state);
  CHECK(run() == first);
}
