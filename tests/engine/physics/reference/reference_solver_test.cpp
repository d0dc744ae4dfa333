#include <catch2/catch.hpp>
#include <cmath>
#include <complex>
#include <numbers>

#include "engine/core/find_root.h"
#include "engine/physics/network.h"

using namespace tactus;

namespace {

constexpr double kMass = 0.0125, kStiffness = 5e6, kExponent = 1.5;
constexpr double kFrame_s = 1.0 / 48000;

Point mass(double kg, double at = 0.0, double velocity = 0.0) {
  return {Point::Kind::Mass, kg, at, velocity, {}};
}
Point ground(double at = 0.0) { return {Point::Kind::Ground, 0.0, at, 0.0, {}}; }
Contact hertz(double loss) {
  return {.lower = 0,
          .upper = 1,
          .stiffness = kStiffness,
          .exponent = kExponent,
          .loss = loss,
          .restitution = {}};
}

Network of(const NetworkElements& elements, Hertz rate = 48_kHz, int oversample = 1) {
  return Network::make(elements, 2, rate, Solver::Reference, oversample).value();
}

/// A network of the reference solution with its state. Signals that are not given are 0.
struct Run {
  explicit Run(const NetworkElements& elements, Hertz rate = 48_kHz)
      : network(of(elements, rate)), state(network.initial_state()) {}
  void step(double signal = 0.0) {
    const double inputs[] = {signal, 0.0};
    network.step(state, inputs);
  }
  double position(int point) const { return network.position(state, point); }
  double velocity(int point) const { return network.velocity(state, point); }
  bool exact() const { return network.network_solver().cost().contact == 0.0; }

  Network network;
  NetworkState state;
};

struct Bounce {
  double contact_time = 0, deepest = 0, speed = 0;
};

/// A body flies into a fixed barrier; times and depth by straight lines and parabolas between frames of 1 us.
Bounce bounce(const Contact& contact, double speed) {
  const double frame_s = 1e-6, gap = 1.5e-5 * speed;
  NetworkElements elements;
  elements.points = {mass(kMass, -gap, speed), ground()};
  elements.contacts = {contact};
  Run flow(elements, Hertz{1e6});
  Bounce result;
  double before[2] = {0, 0};
  for (int n = 1; flow.position(0) > -2 * gap; ++n) {
    flow.step();
    const double now = std::max(0.0, flow.position(0));
    if (before[1] >= before[0] && before[1] > now && now > 0.0) {
      const double slope = 0.5 * (now - before[0]), bend = now - 2 * before[1] + before[0];
      result.deepest = before[1] - 0.5 * slope * slope / bend;
    }
    before[0] = before[1], before[1] = now;
    result.speed = -flow.velocity(0);
    result.contact_time = n * frame_s + flow.position(0) / result.speed - gap / speed;
  }
  return result;
}

/// A woofer with its coil; `elements.points[2]` stands far away.
NetworkElements woofer(double inductance) {
  NetworkElements elements;
  elements.points = {mass(0.035), ground(), ground(10.0)};
  elements.springs = {{1, 0, 1000.0, 1.2, 0.0}};
  elements.coils = {{0, -1, 6.0, 6.5, inductance, {0, {}}}};
  return elements;
}

/// Cone position after `frames` at 5 V.
double thrown(const NetworkElements& elements, int frames, bool exact) {
  Run flow(elements);
  CHECK(flow.exact() == exact);
  for (int n = 0; n < frames; ++n) flow.step(5.0);
  return flow.position(0);
}

/// Cone on its suspension with its coil (voltage: signal 0), a stick that falls on it, a driven table.
NetworkElements drum() {
  NetworkElements elements;
  elements.points = {{Point::Kind::Ground, 0, 0, 0, {}},
                     mass(0.035),
                     {Point::Kind::Motion, 0, 0, 0, {1, {}}},
                     mass(0.0125, 2e-3, -0.5)};
  elements.springs = {{0, 1, 1000.0, 1.2, 0.0}, {2, 3, 20.0, 0.02, 0.0}};
  elements.contacts = {{.lower = 1, .upper = 3, .stiffness = 5e6, .loss = 0.15, .restitution = {}}};
  elements.coils = {{1, -1, 6.0, 6.5, 0.8e-3, {0, {}}}};
  return elements;
}

}  // namespace

TEST_CASE("find_zero: ends within the width on both sides of the zero", "[physics]") {
  const auto found = find_zero([](double x) { return std::cos(x) - x; }, 0.0, 1.0, 1e-14);
  CHECK(found.near == Approx(0.73908513321516064).epsilon(0).margin(1e-14));
  CHECK((found.f_near == 0.0 || std::abs(found.near - found.far) <= 1e-14));
  // Flat on one side: where interpolation is of no use.
  const auto flat = find_zero([](double x) { return x < 0.3 ? -1.0 : 1e-9 * (x - 0.3); }, 0.0, 1.0, 1e-12);
  CHECK(std::abs(flat.near - 0.3) <= 1e-12);
}

TEST_CASE("reference: time, depth and rebound of a body on a fixed barrier to 1e-9", "[physics]") {
  // n_max = (2.5 m v^2 / 2K)^0.4, t_c = 2 sqrt(pi) G(1.4) / G(0.9) n_max / v  (v n' dn = F dn / m).
  const double deepest = std::pow(2.5 * kMass / (2 * kStiffness), 0.4);
  const double time = 2 * std::sqrt(std::numbers::pi) * std::tgamma(1.4) / std::tgamma(0.9) * deepest;
  const auto made = bounce(hertz(0.0), 1.0);
  CHECK(time == Approx(1.16619e-3).epsilon(0).margin(5e-9));
  CHECK(made.contact_time == Approx(time).epsilon(1e-9));
  CHECK(made.deepest == Approx(deepest).epsilon(1e-9));
  CHECK(made.speed == Approx(1.0).epsilon(1e-9));
}

TEST_CASE("reference: the loss of Hunt and Crossley leaves the speed that it must, to 1e-9", "[physics]") {
  // r v - ln(1 + r v) = -r e v - ln(1 - r e v), whatever the mass, the stiffness and the exponent.
  const double rv = GENERATE(0.05, 0.15, 0.5, 1.5);
  const double speed = 0.7;
  const auto equation = [rv](double e) { return rv - std::log1p(rv) + rv * e + std::log1p(-rv * e); };
  const double e =
      find_zero(equation, 1e-3, 1.0 - 1e-9 < 1.0 / rv ? 1.0 - 1e-9 : (1.0 - 1e-9) / rv, 1e-15).near;
  CHECK(bounce(hertz(rv / speed), speed).speed / speed == Approx(e).epsilon(1e-9));
}

TEST_CASE("reference: a restitution holds at every speed to 1e-9", "[physics]") {
  auto contact = hertz(0.0);
  contact.restitution = 0.6;
  const double speed = GENERATE(0.01, 1.0, 5.0);
  CHECK(bounce(contact, speed).speed / speed == Approx(0.6).epsilon(1e-9));
}

TEST_CASE("reference: a woofer without inductance steps as its closed form, to 1e-9", "[physics]") {
  // M x'' + (R + Bl^2/R_e) x' + x/C = Bl V/R_e;  s = -a +- jw,  x = x_end (1 - e^-at (cos wt + a/w sin wt)).
  const double damping = 1.2 + 36.0 / 6.5, a = damping / 0.07, end = 6.0 * 5.0 / 6.5 / 1000.0;
  const std::complex<double> w = std::sqrt(std::complex<double>(1000.0 / 0.035 - a * a));
  for (const int frames : {1, 100, 3000}) {
    const double t = frames * kFrame_s;
    const auto bent = std::exp(-a * t) * (std::cos(w * t) + a / w * std::sin(w * t));
    CHECK(thrown(woofer(0.0), frames, true) == Approx(end * (1.0 - bent.real())).epsilon(1e-9));
  }
}

TEST_CASE("reference: the smaller an inductance, the less it delays", "[physics]") {
  // The force comes L / R_e later, and x grows with the square of the time at first: by less than 2 L / (R_e
  // t).
  const double inductance = GENERATE(1e-6, 1e-9, 1e-10, 1e-12);
  for (const int frames : {1, 100, 3000}) {
    const double late = 2.0 * inductance / 6.5 / (frames * kFrame_s);
    CHECK(thrown(woofer(inductance), frames, true) ==
          Approx(thrown(woofer(0.0), frames, true)).epsilon(late + 1e-12));
  }
}

TEST_CASE("reference: integrated and exponential agree to 1e-9", "[physics]") {
  auto watched = woofer(0.8e-3);
  watched.contacts = {{.lower = 0, .upper = 2, .stiffness = 1e6, .restitution = {}}};
  for (const int frames : {1, 100, 3000})
    CHECK(thrown(watched, frames, false) == Approx(thrown(woofer(0.8e-3), frames, true)).epsilon(1e-9));
}

// Where K rest / m is 10^12 times the decay: x - rest = e^-at (cos wt + a/w sin wt), a = c / 2m, w^2 = K/m -
// a^2.
TEST_CASE("reference: a weak damper beside a spring that is far from its place", "[physics]") {
  constexpr double kRate = 1e5, kDecay = 10.0 / 3.0, kRest = 1e3;
  NetworkElements elements;
  elements.points = {mass(1.0, kRest + 1.0), ground()};
  elements.springs = {{1, 0, kRate * kRate, 2.0 * kDecay, kRest}};
  Run swing(elements);
  REQUIRE(swing.exact());
  const double w = std::sqrt(kRate * kRate - kDecay * kDecay);
  for (int n = 1; n <= 4800; ++n) {
    swing.step();
    if (n % 480 != 0) continue;
    const double t = n * kFrame_s;
    const double expected = std::exp(-kDecay * t) * (std::cos(w * t) + kDecay / w * std::sin(w * t));
    CHECK(swing.position(0) - kRest == Approx(expected).margin(1e-9));
  }
}

TEST_CASE("reference: energy of what loses none stays to 1e-9 over many contacts", "[physics]") {
  NetworkElements elements;
  elements.points = {ground(), mass(0.01, 1e-3, -1.0), mass(0.03, 3e-3, 0.5), ground(4e-3)};
  for (int i = 0; i < 3; ++i)
    elements.contacts.push_back({.lower = i,
                                 .upper = i + 1,
                                 .stiffness = 1e6,
                                 .exponent = 1.0 + 0.5 * i,
                                 .restitution = {},
                                 .offset = i == 2 ? 0.0 : 0.0});
  Run flow(elements);
  const double energy = flow.network.energy(flow.state);
  int touches = 0;
  bool touched = false;
  for (int n = 0; n < 4800; ++n) {
    flow.step();
    const bool now = flow.position(1) > flow.position(2);
    touches += now && !touched;
    touched = now;
    REQUIRE(flow.network.energy(flow.state) == Approx(energy).epsilon(1e-9));
  }
  CHECK(touches > 8);
}

TEST_CASE("reference: a driven point goes in straight lines", "[physics]") {
  // From rest, dragged at speed v by a spring:  x = v t - v/w sin wt. The contact is far away.
  NetworkElements elements;
  elements.points = {{Point::Kind::Motion, 0.0, 0.0, 0.0, {0, {}}}, mass(0.01), ground(10.0)};
  elements.springs = {{0, 1, 400.0, 0.0, 0.0}};
  if (GENERATE(true, false))
    elements.contacts = {{.lower = 1, .upper = 2, .stiffness = 1e5, .restitution = {}}};
  Run flow(elements);
  const double speed = 0.1, w = 200.0;
  for (int n = 0; n <= 4800; ++n) flow.step(speed * n * kFrame_s);
  CHECK(flow.position(1) == Approx(0.01 - speed / w * std::sin(20.0)).epsilon(1e-9));
  CHECK(flow.velocity(1) == Approx(speed - speed * std::cos(20.0)).epsilon(1e-9));
}

TEST_CASE("reference: a body comes to rest in a contact", "[physics]") {
  // The weight of 98.1 mN sinks in by 0.981 um.
  NetworkElements elements;
  elements.points = {ground(), mass(0.01, 1e-4)};
  elements.contacts = {{.lower = 0, .upper = 1, .stiffness = 1e5, .exponent = 1.0, .restitution = 0.2}};
  elements.forces = {{1, {0, {}}}};
  Run flow(elements);
  for (int n = 0; n < 48000; ++n) flow.step(-0.0981);
  CHECK(flow.position(1) == Approx(-0.981e-6).epsilon(1e-9));
  CHECK(flow.velocity(1) == Approx(0.0).epsilon(0).margin(1e-12));
}

TEST_CASE("reference: a sliding body stops where friction says and stays", "[physics]") {
  // m v' = -mu N: it stops after v / (mu N / m) at v^2 / (2 mu N / m).
  NetworkElements elements;
  elements.points = {mass(0.1, 0.0, 1.0), ground()};
  elements.frictions = {{.lower = 0, .upper = 1, .law = {.kinetic = 0.3}, .normal = {0, {}}}};
  Run flow(elements);
  const double normal = 0.981, slows = 0.3 * 0.981 / 0.1;
  for (int n = 0; n < 24000; ++n) flow.step(normal);
  CHECK(flow.position(0) == Approx(1.0 / (2 * slows)).epsilon(1e-9));
  CHECK(flow.velocity(0) == 0.0);
  CHECK(flow.state.sliding[0] == 0.0);
}

TEST_CASE("reference: a belt that turns round pushes a body the other way, no faster than friction does",
          "[physics]") {
  // m v' = mu N while the belt is faster than the body, -mu N from the frame on in which it turns round.
  NetworkElements elements;
  elements.points = {{Point::Kind::Motion, 0.0, 0.0, 0.0, {1, {}}}, mass(0.01)};
  elements.frictions = {{.lower = 0, .upper = 1, .law = {.kinetic = 0.3}, .normal = {0, {}}}};
  Run flow(elements);
  constexpr double kAcceleration = 0.3 / 0.01, kForth = 100, kBack = 150;
  for (int n = 0; n <= kForth + kBack; ++n) {
    const double inputs[] = {1.0, kFrame_s * (n <= kForth ? n : 2 * kForth - n)};
    flow.network.step(flow.state, inputs);
  }
  const double forth = kForth * kFrame_s, back = kBack * kFrame_s;
  CHECK(flow.velocity(1) == Approx(kAcceleration * (forth - back)).epsilon(1e-9));
  CHECK(flow.position(1) ==
        Approx(kAcceleration * (0.5 * forth * forth + forth * back - 0.5 * back * back)).epsilon(1e-9));
}

TEST_CASE("reference: dry friction takes 2 mu N / k from a swing at each turn until it holds", "[physics]") {
  // From 10.5 mu N / k: -8.5, 6.5, -4.5, 2.5, -0.5, where the spring pulls less than mu N.
  NetworkElements elements;
  elements.points = {mass(0.01, 10.5e-3), ground()};
  elements.springs = {{1, 0, 100.0, 0.0, 0.0}};
  elements.frictions = {{.lower = 0, .upper = 1, .law = {.kinetic = 0.1}, .normal = {0, {}}}};
  Run flow(elements);
  // Five half swings of pi / 100 s, to the last frame before the stop and to the second one after it.
  for (int n = 0; n < 7539; ++n) flow.step(1.0);
  CHECK(flow.velocity(0) != 0.0);
  for (int n = 0; n < 2; ++n) flow.step(1.0);
  CHECK(flow.velocity(0) == 0.0);
  CHECK(flow.position(0) == Approx(-0.5e-3).epsilon(1e-8));
  CHECK(flow.state.friction_force[0] == Approx(0.05).epsilon(1e-8));
}

TEST_CASE("reference: a plectrum slips at its limit and takes hold again on the way back", "[physics]") {
  // Driven at 0.1 m/s it slips at n = 0.2 N / 100 N/m = 2 mm, after 20 ms.
  NetworkElements elements;
  elements.points = {{Point::Kind::Motion, 0.0, 0.0, 0.0, {0, {}}}, ground()};
  elements.bonds = {{.lower = 0, .upper = 1, .law = std::make_shared<LinearBond>(100.0), .limit = 0.2}};
  Run flow(elements, Hertz{1e3});
  flow.step();
  std::vector<double> forces;
  double at = 0.0;
  for (int n = 0; n < 60; ++n) {
    at += n < 30 ? 1e-4 : -2e-4;
    flow.step(at);
    const bool holds = flow.state.slipped[0] == 0.0;
    forces.push_back(holds ? 100.0 * at : 0.0);
  }
  CHECK(forces[18] == Approx(0.19).epsilon(1e-9));
  CHECK(forces[21] == 0.0);
  CHECK(forces[43] == 0.0);
  CHECK(forces[46] == Approx(100.0 * (3e-3 - 17 * 2e-4)).epsilon(1e-9));
}

TEST_CASE("reference: a wave port is a force of twice the wave against its impedance", "[physics]") {
  // m v' = 2 a - Z v:  v = 2 a / Z (1 - e^(-Z t / m)).
  NetworkElements elements;
  elements.points = {mass(0.01)};
  elements.ports = {{.on = 0, .impedance = 2.0, .wave = {0, {}}}};
  Run flow(elements);
  for (int n = 0; n < 240; ++n) flow.step(0.5);
  const double v = 0.5 * (1.0 - std::exp(-1.0));
  CHECK(flow.velocity(0) == Approx(v).epsilon(1e-9));
}

TEST_CASE("reference: does not depend on the number of steps a frame", "[physics]") {
  const auto whole = of(drum()), parts = of(drum(), 48_kHz, 4);
  auto one = whole.initial_state(), other = parts.initial_state();
  for (int n = 0; n < 2400; ++n) {
    const double inputs[] = {n < 960 ? 5.0 : 0.0, 1e-3 * std::sin(0.01 * n)};
    whole.step(one, inputs);
    parts.step(other, inputs);
  }
  for (const int point : {1, 3}) {
    CHECK(whole.position(one, point) == Approx(parts.position(other, point)).epsilon(0).margin(1e-11));
    CHECK(whole.velocity(one, point) == Approx(parts.velocity(other, point)).epsilon(0).margin(1e-8));
  }
  CHECK(whole.current(one, 0) == Approx(parts.current(other, 0)).epsilon(0).margin(1e-8));
}

TEST_CASE("reference: passive and explicit steps come to it as they get smaller", "[physics]") {
  const auto solver = GENERATE(Solver::Passive, Solver::Explicit, Solver::Implicit);
  const auto far = [&](int oversample) {
    const auto reference = of(drum());
    const auto stepped = Network::make(drum(), 2, 48_kHz, solver, oversample).value();
    auto wanted = reference.initial_state(), found = stepped.initial_state();
    double most = 0;
    for (int n = 0; n < 960; ++n) {
      const double inputs[] = {5.0, 0.0};
      reference.step(wanted, inputs);
      stepped.step(found, inputs);
      for (const int point : {1, 3})
        most = std::max(most, std::abs(reference.position(wanted, point) - stepped.position(found, point)));
    }
    return most;
  };
  // First order at least: a sixteenth of the step, a twelfth of the error.
  const double coarse = far(1), fine = far(16);
  CAPTURE(coarse, fine);
  CHECK(fine < coarse / 12);
  CHECK(fine < 2e-6);
}

TEST_CASE("reference: a reset repeats it", "[physics]") {
  const auto network = of(drum());
  auto state = network.initial_state();
  const double inputs[] = {5.0, 0.0};
  for (int n = 0; n < 300; ++n) network.step(state, inputs);
  const double first = network.position(state, 3);
  network.reset(state);
  for (int n = 0; n < 300; ++n) network.step(state, inputs);
  CHECK(network.position(state, 3) == first);
}
