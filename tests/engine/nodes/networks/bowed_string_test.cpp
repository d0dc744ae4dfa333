#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cmath>

#include "tests/support/graphs/graph_runner.h"

using namespace tactus;

// A bowed string as a graph file: two waveguides on one point, and friction with two branches.
namespace {

constexpr double kRate = 48000, kPitch = 147, kBeta = 0.11;
constexpr double kImpedance = 0.55;  // of a cello's D string [N s/m]
constexpr double kBowSpeed = 0.05, kHolding = 0.8, kKinetic = 0.35;

std::string string_text(double bridge) {
  return fmt::format(R"(
format = 1
[inputs]
bow   = {{ unit = "m" }}
press = {{ unit = "N" }}
[networks.string]
spot   = {{ type = "mass", mass = "0.01 g" }}
nut    = {{ type = "port", on = "spot", impedance = {z}, wave = "long" }}
bridge = {{ type = "port", on = "spot", impedance = {z}, wave = "short" }}
hand   = {{ type = "motion", position = "bow" }}
hair   = {{ type = "friction", between = ["hand", "spot"], normal = "press", kinetic = {kinetic}, holding = {holding}, speed = "0.02 m/s" }}
[nodes]
long  = {{ type = "waveguide", wave = "string.nut.wave", pitch = {long_hz}, gain = 0.999, loss = 1 }}
short = {{ type = "waveguide", wave = "string.bridge.wave", pitch = {short_hz}, gain = {bridge}, loss = 1 }}
[outputs]
speed = {{ from = "string.spot.velocity", unit = "m/s" }}
)",
                     fmt::arg("z", kImpedance), fmt::arg("kinetic", kKinetic), fmt::arg("holding", kHolding),
                     fmt::arg("long_hz", kPitch / (1 - kBeta)), fmt::arg("short_hz", kPitch / kBeta),
                     fmt::arg("bridge", bridge));
}

/// Speed of the string under the bow. The bow starts at 0.5 N, where it catches the string, and reaches its
/// force after a second: what holds then is the motion, not the start.
std::vector<double> bowed(double force, double bridge, double seconds) {
  const int frames = static_cast<int>(seconds * kRate);
  test::Channels in(2, std::vector<double>(static_cast<std::size_t>(frames)));
  for (std::size_t n = 0; n < in[0].size(); ++n) {
    const double t = static_cast<double>(n) / kRate;
    in[0][n] = kBowSpeed * t;
    in[1][n] = 0.5 + (force - 0.5) * std::clamp(2 * t - 1, 0.0, 1.0);
  }
  return test::run(*test::engine_of(string_text(bridge)), in, frames, {256})[0];
}

/// Normalised autocorrelation of the last 0.5 s, a period later: the best within 3 %, since friction
/// flattens.
double periodicity(const std::vector<double>& x) {
  const auto window = static_cast<std::size_t>(0.3 * kRate),
             start = x.size() - static_cast<std::size_t>(0.5 * kRate);
  double mean = 0;
  for (std::size_t n = start; n < x.size(); ++n) mean += x[n] / static_cast<double>(x.size() - start);
  double best = 0;
  for (auto lag = static_cast<std::size_t>(0.97 * kRate / kPitch);
       static_cast<double>(lag) < 1.04 * kRate / kPitch; ++lag) {
    double product = 0, early = 0, late = 0;
    for (std::size_t n = start; n < start + window; ++n) {
      product += (x[n] - mean) * (x[n + lag] - mean);
      early += (x[n] - mean) * (x[n] - mean);
      late += (x[n + lag] - mean) * (x[n + lag] - mean);
    }
    best = std::max(best, product / std::sqrt(early * late));
  }
  return best;
}

/// Above it the bow cannot let go in time: 2 Z v / (beta (mu_s - mu_d)). Schelleng, JASA 53, 1973.
const double kMostForce = 2 * kImpedance * kBowSpeed / (kBeta * (kHolding - kKinetic));

}  // namespace

TEST_CASE("bowed string: it is periodic below Schelleng's largest force and not above", "[nodes]") {
  const double bridge = GENERATE(0.98, 0.9);
  INFO("gain at the bridge " << bridge);
  CHECK(kMostForce == Approx(1.111).epsilon(0.001));
  CHECK(periodicity(bowed(0.9 * kMostForce, bridge, 2)) > 0.95);
  CHECK(periodicity(bowed(1.1 * kMostForce, bridge, 2)) < 0.8);
}

TEST_CASE("bowed string: it sticks to the bow and slips once a period, as Helmholtz saw", "[nodes]") {
  const auto x = bowed(0.8 * kMostForce, 0.9, 2);
  const auto start = x.size() - static_cast<std::size_t>(0.5 * kRate);
  std::size_t sticking = 0, slips = 0;
  for (std::size_t n = start; n < x.size(); ++n) {
    sticking += std::abs(x[n] - kBowSpeed) < 0.2 * kBowSpeed;
    slips += x[n - 1] >= -2 * kBowSpeed && x[n] < -2 * kBowSpeed;
  }
  // A share 1 - beta of each period, less what the rounded corner takes; 73 periods in half a second.
  CHECK(static_cast<double>(sticking) / (0.5 * kRate) == Approx(1 - kBeta).epsilon(0).margin(0.1));
  CHECK(static_cast<double>(slips) == Approx(0.5 * kPitch).epsilon(0).margin(2));
}
