#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "engine/study/orbits/bouncing_ball.h"
#include "tests/support/graphs/graph_runner.h"

// A ball on a driven table as a network: its contact takes time, which the exact map knows nothing of.

using namespace tactus;
using namespace tactus::test;

namespace {

constexpr double kRestitution = 0.5, kMass = 0.0027, kGravity = 9.81, kRate = 48000.0;
constexpr double kTurn = 2 * std::numbers::pi * 30.0;  // 30 Hz

/// The ball starts on the orbit of one bounce a period; outputs its push on the table. `contact_s`: half a
/// period of the ball on the contact's spring.
std::string table_and_ball(double drive, double contact_s, const char* solver) {
  const auto orbit = BouncingBall(drive, kRestitution).orbit(1);
  const double amplitude = drive * kGravity / (kTurn * kTurn), speed = orbit.speed * kGravity / kTurn;
  const double time = orbit.phase / kTurn;  // of the first landing
  const double at = amplitude * std::sin(orbit.phase) + speed * time - 0.5 * kGravity * time * time;
  const double stiffness = kMass * std::pow(std::numbers::pi / contact_s, 2);
  return fmt::format(R"(
format = 1
name = "bouncing ball"
[networks.world]
solver = "{}"
table = {{ type = "motion", position = "shake" }}
ball = {{ type = "mass", mass = {:.17g}, at = {:.17g}, velocity = {:.17g} }}
lens = {{ type = "contact", between = ["table", "ball"], stiffness = {:.17g}, exponent = 1, restitution = {} }}
weight = {{ type = "force", on = "ball", force = {:.17g} }}
[nodes]
shake = {{ type = "sine", frequency = "30 Hz", level = {:.17g} }}
[outputs]
push = {{ from = "world.lens / 1 N" }}
)",
                     solver, kMass, at, -speed + kGravity * time, stiffness, kRestitution, -kMass * kGravity,
                     amplitude);
}

/// By how much long and short flights differ, mean of 100 pairs. [periods of the drive]
double alternation(const std::vector<double>& landings) {
  double sum = 0;
  const auto last = landings.size() - 1;
  for (std::size_t i = 0; i < 100; ++i)
    sum += (i % 2 ? -1 : 1) * (landings[last - i] - 2 * landings[last - i - 1] + landings[last - i - 2]);
  return std::abs(sum) / 100;
}

double network_alternation(double drive, double contact_s, const char* solver) {
  const auto engine = engine_of(table_and_ball(drive, contact_s, solver));
  const auto push = run(*engine, {}, 12 * 48000, {64}).front();
  std::vector<double> touches;
  for (std::size_t n = 1; n < push.size(); ++n)
    if (push[n] > 0.0 && push[n - 1] == 0.0) touches.push_back(static_cast<double>(n) * 30.0 / kRate);
  REQUIRE(touches.size() > 300);
  return alternation(touches);
}

double exact_alternation(double drive) {
  const BouncingBall ball(drive, kRestitution);
  auto bounce = ball.orbit(1);
  bounce.speed += 1e-3;
  std::vector<double> landings;
  for (int i = 0; i < 360; ++i) {
    bounce = ball.next(bounce);
    landings.push_back(bounce.phase / (2 * std::numbers::pi));
  }
  return alternation(landings);
}

/// Where flights begin to alternate: their difference grows as the root of the drive's distance from there,
/// and nearer to it than these two drives the fractions of frames at the landings hide it.
template <class Alternation>
double doubles_at(const Alternation& alternation_at) {
  const double near = std::pow(alternation_at(1.54), 2), far = std::pow(alternation_at(1.56), 2);
  return 1.54 - 0.02 * near / (far - near);
}

}  // namespace

TEST_CASE(
    "bouncing network: its period doubles within 3 % of the exact drive, closer for shorter "
    "contacts",
    "[physics]") {
  const auto* solver = GENERATE("passive", "explicit");
  const auto doubling = [solver](double contact_s) {
    return doubles_at([=](double drive) { return network_alternation(drive, contact_s, solver); });
  };
  const double exact = BouncingBall::orbit_doubles(1, kRestitution);
  CHECK(doubles_at(exact_alternation) == Approx(exact).epsilon(1e-3));
  const double soft = std::abs(doubling(1e-3) / exact - 1), hard = std::abs(doubling(0.25e-3) / exact - 1);
  CAPTURE(solver, soft, hard);
  CHECK(soft < 0.03);
  CHECK(hard < 0.5 * soft);
}
