// Bodies and lines on networks: waves of force between a mass and what hangs on it.
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <complex>
#include <numbers>

#include "engine/core/units.h"
#include "engine/dsp/strings/string_loop.h"
#include "tests/support/graphs/graph_runner.h"
#include "tests/support/graphs/node_runner.h"

using namespace tactus;
using namespace tactus::test;

namespace {
constexpr double kMass = 0.02, kImpedance = 20;

/// A mass [kg] behind a port of kImpedance [N s/m], on which a node hangs. An impulse of 1 at `kick` gives it
/// 1 N s in a frame.
std::string mass_with(const std::string& hung) {
  return fmt::format(
      "format = 1\n[inputs]\nkick = {{}}\n[networks.n]\nsolver = \"passive\"\n"
      "m = {{ type = \"mass\", mass = {} }}\n"
      "port = {{ type = \"port\", on = \"m\", impedance = {}, wave = \"back\" }}\n"
      "strike = {{ type = \"force\", on = \"m\", force = \"kick * 1 N s * system.rate\" }}\n"
      "[nodes]\nback = {{ {} }}\n"
      "[outputs]\nv = {{ from = \"n.m.velocity\", unit = \"m/s\" }}\ne = {{ from = \"n.energy\", unit = "
      "\"J\" "
      "}}\n",
      kMass, kImpedance, hung);
}

/// Velocity and energy of the mass after a blow of kMass N s, which sets it off at 1 m/s.
Channels struck(const std::string& hung, int frames, double rate = 48000) {
  CompileOptions options;
  options.sample_rate = Hertz{rate};
  const auto engine = engine_of(mass_with(hung), options);
  return run(*engine, {impulse(frames, kMass)}, frames, {64});
}

std::string line(double pitch, double gain) {
  return fmt::format("type = \"waveguide\", wave = \"n.port.wave\", pitch = {}, gain = {}, loss = 0", pitch,
                     gain);
}

std::complex<double> phasor(const Samples& y, std::size_t from, std::size_t window, double turns) {
  std::complex<double> sum = 0;
  for (std::size_t n = 0; n < window; ++n) {
    const double hann = 1 - std::cos(2 * kPi * static_cast<double>(n) / static_cast<double>(window));
    sum += hann * y[from + n] * std::polar(1.0, -2 * kPi * turns * static_cast<double>(from + n));
  }
  return sum;
}

/// Of what rings loudest within 8 % of `hertz`: how far its phase turns from one Hann window to a later one.
double measured_hertz(const Samples& y, double hertz, double rate) {
  const std::size_t window = y.size() / 2, first = y.size() / 4, apart = y.size() / 16;
  double loudest = 0, peak = hertz;
  for (double f = 0.92 * hertz; f < 1.08 * hertz; f += 0.5 * rate / static_cast<double>(window)) {
    const double level = std::abs(phasor(y, first, window, f / rate));
    if (level > loudest) loudest = level, peak = f;
  }
  const double turned =
      std::arg(phasor(y, first + apart, window, peak / rate) / phasor(y, first, window, peak / rate));
  return peak + turned * rate / (2 * kPi * static_cast<double>(apart));
}

double root(double low, double high, auto function) {
  for (int i = 0; i < 80; ++i) {
    const double middle = (low + high) / 2;
    (function(low) * function(middle) <= 0 ? high : low) = middle;
  }
  return low;
}

/// (2 pi f)^2
double square_pulsation(double hertz) { return 4 * kPi * kPi * hertz * hertz; }

double largest(const Samples& y, std::size_t from) {
  double most = 0;
  for (std::size_t n = from; n < y.size(); ++n) most = std::max(most, std::abs(y[n]));
  return most;
}

}  // namespace

// m v' = -Z v.
TEST_CASE("waves: a mass struck on an endless line loses its speed as exp of -Z t / m", "[nodes]") {
  const auto v = struck(line(100, 0), 1000)[0];
  for (std::size_t n = 4; n < v.size(); ++n) {
    // The middle of the blow is half a frame after its start.
    const double t = (static_cast<double>(n) - 0.5) / 48000;
    CHECK(v[n] == Approx(std::exp(-kImpedance * t / kMass)).epsilon(0).margin(1e-3));
  }
}

// w m = Z cot(w L / c) with L / c = 1 / (2 pitch).
TEST_CASE("waves: a mass on a fixed string has the frequencies of the transcendental equation", "[nodes]") {
  const double pitch = GENERATE(93.7, 310.3);
  const auto v = struck(line(pitch, 1), 32768)[0];
  for (int k = 0; k < 4; ++k) {
    const auto balance = [&](double f) {
      const double angle = kPi * f / pitch;
      return 2 * kPi * f * kMass * std::sin(angle) - kImpedance * std::cos(angle);
    };
    const double expected = root((k + 1e-9) * pitch, (k + 0.9999) * pitch, balance);
    CHECK(measured_hertz(v, expected, 48000) == Approx(expected).epsilon(1e-3));
  }
}

TEST_CASE("waves: a mass on a string without losses gains no energy in a million frames", "[nodes]") {
  const auto energy = struck(line(93.7, 1), 1000000)[1];
  CHECK(largest(energy, 0) <= kMass / 2 * (1 + 1e-9));
  CHECK(largest(energy, 999000) > 1e-4 * kMass);
}

// A body pushed for a long time has moved as its springs let it: the mass with it, the same way.
TEST_CASE("waves: a mass and the body at its port move together", "[nodes]") {
  auto text = mass_with(
      "type = \"modal_body\", wave = \"n.port.wave\", impedance = 20, frequencies = [200], decays = [0.02], "
      "masses = [0.05]");
  text +=
      "x = { from = \"n.m.position\", unit = \"m\" }\ny = { from = \"back.position\", unit = \"m\" }\n"
      "f = { from = \"back.force\", unit = \"N\" }\n";
  const auto engine = engine_of(text);
  // 3 N from frame 0 on.
  const auto output = run(*engine, {Samples(24000, 3.0 / 48000)}, 24000, {64});
  const double sigma = 3 * std::numbers::ln10 / 0.02,
               stiffness = 0.05 * (square_pulsation(200) + sigma * sigma);
  CHECK(output[3].back() == Approx(3 / stiffness).epsilon(2e-3));
  CHECK(output[4].back() == Approx(3).epsilon(1e-6));
  // The frames between the two are a spring.
  CHECK(output[2].back() - output[3].back() ==
        Approx(3 * TACTUS_WAVEGUIDE_PORT / (2 * 20 * 48000.0)).epsilon(1e-3));
}

// Two modes and a mass are two oscillators: Y(s) s M = -1, a quadratic equation in s^2.
TEST_CASE("waves: a mass on a body of two modes has the frequencies of both, nearer at higher rates",
          "[nodes]") {
  const double m1 = 0.05, m2 = 0.03, w1 = square_pulsation(200), w2 = square_pulsation(700);
  const std::string body = fmt::format(
      "type = \"modal_body\", wave = \"n.port.wave\", impedance = {}, frequencies = [200, 700], decays = "
      "[5], masses "
      "= [{}, {}]",
      kImpedance, m1, m2);
  // (q + w1)(q + w2) + q M (q + w2) / m1 + q M (q + w1) / m2 = 0 for q = s^2.
  const double a = 1 + kMass / m1 + kMass / m2, b = w1 + w2 + kMass * w2 / m1 + kMass * w1 / m2, c = w1 * w2;
  const double split = std::sqrt(b * b - 4 * a * c);
  for (const double q : {(b - split) / (2 * a), (b + split) / (2 * a)}) {
    const double expected = std::sqrt(q) / (2 * kPi);
    const auto off = [&](double rate) {
      return std::abs(
          measured_hertz(struck(body, static_cast<int>(0.7 * rate), rate)[0], expected, rate) / expected - 1);
    };
    const double at_48k = off(48000), at_192k = off(192000);
    CAPTURE(expected, at_48k, at_192k);
    CHECK(at_48k < 3e-2);
    CHECK(at_192k < 0.3 * at_48k);
  }
}
