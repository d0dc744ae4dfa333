#include "engine/dsp/resonators/modal_body.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <deque>
#include <numbers>

#include "tests/support/graphs/node_runner.h"

using namespace tactus;
using namespace tactus::test;

namespace {

constexpr double kRate = 48000;

std::vector<BodyMode> modes_of(int count) {
  std::vector<BodyMode> modes;
  for (int k = 0; k < count; ++k) {
    const double f = 150 * std::pow(100.0, k / std::max(1.0, count - 1.0));
    modes.push_back({f, 1.2 * std::sqrt(150 / f), 0.05 * (1 + k % 3)});
  }
  return modes;
}

/// A mass that a force F moves, by the trapezoidal rule: m (v' - v) fs = F, seen at the mean of v and v'.
struct WaveMass {
  double mass, impedance, v = 0;
  double step(double wave) {
    const double inertia = 2 * mass * kRate;
    const double middle = (inertia * v + 2 * wave) / (inertia + impedance);
    v = 2 * middle - v;
    return wave - impedance * middle;
  }
  double energy() const { return mass * v * v / 2; }
};

/// What the modes store: sum of (s_m^2 / R_m + s_k^2 / R_k) / (4 fs).
double energy_of(const ModalBody& body) {
  double sum = 0;
  for (const auto& m : body.groups())
    for (int k = 0; k < 8 && m.give[k] > 0; ++k)
      sum += (m.mass[k] * m.mass[k] / m.mass_turn[k] + m.spring[k] * m.spring[k] / m.spring_turn[k]) /
             (2 * kRate * m.give[k]);
  return sum;
}

/// Waves under way.
struct Way {
  explicit Way(int frames) : waves(static_cast<std::size_t>(frames), 0.0) {}
  double pass(double wave) {
    waves.push_back(wave);
    const double first = waves.front();
    waves.pop_front();
    return first;
  }
  double energy(double impedance) const {
    double sum = 0;
    for (const double wave : waves) sum += wave * wave;
    return sum / impedance / kRate;
  }
  std::deque<double> waves;
};

}  // namespace

// Without a load (Z next to nothing) the velocity is two terms of one recurrence whose pole is exact.
TEST_CASE("modal_body: a mode rings at its frequency and falls by 60 dB in its decay", "[dsp]") {
  const double frequency = GENERATE(50.0, 440.0, 9000.0, 23000.0);
  const double decay = GENERATE(0.05, 2.0);
  ModalBody body(std::vector<BodyMode>{{frequency, decay, 0.1}}, 1e-12, Hertz{kRate});
  Samples v{body.step(1).velocity};
  for (int n = 1; n < 2000; ++n) v.push_back(body.step(0).velocity);
  const double w = 2 * std::numbers::pi * frequency / kRate, r = std::pow(1e-3, 1 / (decay * kRate));
  double worst = 0;
  for (std::size_t n = 3; n < v.size(); ++n)
    worst = std::max(worst, std::abs(v[n] - 2 * r * std::cos(w) * v[n - 1] + r * r * v[n - 2]));
  // Some roundings of states that add up to v.
  CHECK(worst < 1e-13 * std::abs(v[0]));
}

// For a step of force, one over the sum of masses is the first acceleration; far below its modes a body is a
// spring.
TEST_CASE("modal_body: it begins as a mass and rests as a spring", "[dsp]") {
  const std::vector<BodyMode> modes{{300, 0.2, 0.2}, {900, 0.1, 0.05}};
  ModalBody body(modes, 1e-9, Hertz{kRate});
  const auto first = body.step(0.5);
  CHECK(first.force == Approx(1).epsilon(1e-9));
  // A force of 1 N from frame 0 on, rising in half a frame: v = F / (2 m fs) less what spring and loss take.
  CHECK(first.velocity == Approx((1 / 0.2 + 1 / 0.05) / (2 * kRate)).epsilon(5e-3));
  tactus_body_answer last{};
  for (int n = 0; n < 48000; ++n) last = body.step(0.5);
  double give = 0;
  for (const auto& mode : modes) {
    const double w = 2 * std::numbers::pi * mode.frequency_hz, sigma = 3 * std::numbers::ln10 / mode.decay_s;
    give += 1 / (mode.mass_kg * (w * w + sigma * sigma));
  }
  // The stiffness that makes a frequency exact at this rate lies (w / fs)^2 / 12 beside the one of a spring:
  // 0.1 %.
  CHECK(last.position == Approx(give).epsilon(2e-3));
  CHECK(std::abs(last.velocity) < 1e-9);
}

TEST_CASE("modal_body: what it holds and has lost is what came in, less what went out", "[dsp]") {
  const int count = GENERATE(1, 5, 8, 40);
  const double impedance = GENERATE(0.01, 3.0, 1e4);
  const auto modes = modes_of(count);
  ModalBody body(modes, impedance, Hertz{kRate});
  const auto wave = noise(20000, 11);
  // Of one mode the loss is known as well: c v^2.
  const double loss = count == 1 ? BodyModeDesign{modes[0], Hertz{kRate}}.loss_ohm : 0;
  double given = 0, lost = 0, through = 0, worst = 0;
  for (const double a : wave) {
    const auto answer = body.step(a);
    given += (a * a - answer.wave * answer.wave) / impedance / kRate;
    through += a * a / impedance / kRate;
    lost += loss * answer.velocity * answer.velocity / kRate;
    const double left = given - lost - energy_of(body);
    worst = std::max(worst, count == 1 ? std::abs(left) : -left);
  }
  // Energy beyond what came in would be made from nothing: at most the rounding of 20000 frames of it.
  CHECK(worst <= 1e-12 * through);
  CHECK(through > 0);
}

TEST_CASE("modal_body: no frequency comes back louder than it came", "[dsp]") {
  const double impedance = GENERATE(0.01, 3.0, 1e4);
  const auto modes = modes_of(20);
  for (double f = 1; f < 24000; f *= 1.0013) {
    const auto delay = std::polar(1.0, -2 * std::numbers::pi * f / kRate);
    std::complex<double> admittance = 0;
    for (const auto& mode : modes) admittance += BodyModeDesign{mode, Hertz{kRate}}.admittance(delay);
    CHECK(admittance.real() >= 0);
    CHECK(std::abs((1.0 - impedance * admittance) / (1.0 + impedance * admittance)) <= 1 + 1e-12);
  }
}

TEST_CASE("modal_body: a mass joined to it by waves never gains energy, whatever the way", "[dsp]") {
  const int frames = GENERATE(1, 2, 7, 100);
  const double impedance = GENERATE(0.1, 50.0);
  WaveMass mass{0.02, impedance, 1.0};
  ModalBody body(modes_of(12), impedance, Hertz{kRate});
  Way there(frames), back(frames);
  const double whole = mass.energy();
  double before = whole, grown = 0, to_body = 0;
  for (int n = 0; n < 48000; ++n) {
    const double arriving = back.pass(body.step(there.pass(to_body)).wave);
    to_body = mass.step(arriving);
    // What the mass has just sent is under way as well.
    const double now = mass.energy() + energy_of(body) + there.energy(impedance) + back.energy(impedance) +
                       to_body * to_body / impedance / kRate;
    grown = std::max(grown, now - before);
    before = now;
  }
  CHECK(grown <= 1e-14 * whole);  // a rounding a frame
  CHECK(before < 0.999 * whole);
}

TEST_CASE("modal_body: another body goes on where one was", "[dsp]") {
  ModalBody first(modes_of(20), 2, Hertz{kRate}), second(modes_of(20), 2, Hertz{kRate});
  for (const double a : noise(300, 5)) first.step(a);
  second.adopt(first);
  for (int n = 0; n < 300; ++n) {
    const auto one = first.step(0), other = second.step(0);
    // The sum that is kept from frame to frame is taken again, in the same order.
    REQUIRE(one.wave == other.wave);
    REQUIRE(one.position == other.position);
  }
}
