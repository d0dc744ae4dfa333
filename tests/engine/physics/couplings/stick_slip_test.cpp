#include "tests/engine/physics/couplings/stick_slip.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>

#include "engine/core/units.h"

using namespace tactus;

namespace {

enum PlaceOf { kBlock, kGround, kBelt };

Friction rub(int lower, int upper, FrictionLaw law, int normal) {
  return {.lower = lower, .upper = upper, .law = law, .normal = {normal, {}}};
}

/// A block on a spring to the ground and a belt that is driven by signal 0; normal forces are signals 1, 2.
NetworkElements block(double mass, double stiffness, double damping, double at = 0.0) {
  NetworkElements elements;
  elements.points = {{Point::Kind::Mass, mass, at, 0, {}},
                     {Point::Kind::Ground, 0, 0, 0, {}},
                     {Point::Kind::Motion, 0, 0, 0, {0, {}}}};
  elements.springs = {{kGround, kBlock, stiffness, damping, 0.0}};
  return elements;
}

constexpr FrictionLaw kStribeck{0.2, {{{0.2, 0.02}, {}}}};

test::StickSlip belt(const char* name, double speed, FrictionLaw law, NetworkElements elements, int frames) {
  elements.frictions = {rub(kBelt, kBlock, law, 1)};
  return {name,   elements,
          2,      frames,
          kBlock, [speed](int n, double* inputs) {
            inputs[0] = speed * n / 48e3, inputs[1] = 2.0; }};
}

test::StickSlip bow() {
  NetworkElements elements;
  for (int i = 0; i < 5; ++i) elements.points.push_back({Point::Kind::Mass, 0.2e-3, 0, 0, {}});
  elements.points.push_back({Point::Kind::Ground, 0, 0, 0, {}});
  elements.points.push_back({Point::Kind::Motion, 0, 0, 0, {0, {}}});
  for (int i = 0; i <= 5; ++i) elements.springs.push_back({i == 0 ? 5 : i - 1, i, 4e3, 0.002, 0.0});
  elements.frictions = {rub(6, 1, kRosin, 1)};
  return {"bow", elements, 2,
          1200,  1,        [](int n, double* inputs) {
            inputs[0] = 0.2 * n / 48e3, inputs[1] = 0.5; }};
}

test::StickSlip rough_wall() {
  auto elements = block(0.05, 2000.0, 0.0, 0.004);
  elements.frictions = {rub(kBlock, kGround, {0.3, {{{0.1, 0.05}, {}}}}, 1)};
  return {"rough wall", elements, 2,
          4800,         kBlock,   [](int, double* inputs) {
            inputs[0] = 0.0, inputs[1] = 2.0; }};
}

test::StickSlip two_frictions() {
  auto elements = block(0.05, 500.0, 0.05);
  elements.frictions = {rub(kBelt, kBlock, kStribeck, 1),
                        rub(kBlock, kGround, {0.1, {{{0.1, 0.02}, {}}}}, 2)};
  return {"two frictions", elements, 3, 4800, kBlock, [](int n, double* inputs) {
            inputs[0] = 0.1 * n / 48e3, inputs[1] = 2.0, inputs[2] = 1.0;
          }};
}

test::StickSlip varying_normal() {
  auto elements = block(0.02, 1000.0, 0.02);
  elements.frictions = {rub(kBelt, kBlock, kStribeck, 1)};
  return {"varying normal force", elements, 2, 4800, kBlock, [](int n, double* inputs) {
            inputs[0] = 0.1 * n / 48e3, inputs[1] = 2.0 + 1.5 * std::sin(2 * kPi * 37.0 * n / 48e3);
          }};
}

std::array<test::StickSlip, 6> scenes() {
  return {belt("fast belt", 0.1, kStribeck, block(0.05, 500.0, 0.0), 4800),
          belt("slow belt", 0.02, {0.2, {{{0.2, 0.005}, {}}}}, block(0.01, 2000.0, 0.0), 2400),
          bow(),
          rough_wall(),
          two_frictions(),
          varying_normal()};
}

}  // namespace

TEST_CASE("friction: more steps are closer to the motion, on six stick-slip scenes", "[physics]") {
  // Orders of the error, from one step a frame to sixteen. Second order, but where what drives a friction
  // jumps from frame to frame: a normal force held over each frame; a belt that starts at once under two
  // frictions.
  for (const auto& scene : scenes()) {
    const bool jumps = scene.signals == 3 || scene.name == "varying normal force";
    const auto truth = test::stick_slip_truth(scene, 48_kHz, 64);
    for (const auto solver : {Solver::Explicit, Solver::Passive, Solver::Implicit, Solver::Exact}) {
      double first = 0.0, last = 1.0;
      for (int steps = 1; steps <= 16; steps *= 2) {
        const double error = test::stick_slip_error(scene, truth, 48_kHz, solver, steps);
        CAPTURE(scene.name, static_cast<int>(solver), steps, error);
        CHECK(error < last);
        if (steps == 1) first = error;
        last = error;
      }
      CAPTURE(scene.name, static_cast<int>(solver), first, last);
      CHECK(first < (scene.name == "bow" ? 0.15 : 3e-4));  // the bow's friction falls within a frame
      CHECK(std::log2(first / last) / 4 > (jumps ? 0.95 : 1.4));
    }
  }
}

TEST_CASE("friction: the integration that stick and slip are measured against converges", "[physics]") {
  for (const auto& scene : scenes()) {
    const auto fine = test::stick_slip_truth(scene, 48_kHz, 64),
               coarse = test::stick_slip_truth(scene, 48_kHz, 32);
    double most = 0.0, largest = 0.0;
    for (std::size_t n = 0; n < fine.size(); ++n) {
      most = std::max(most, std::abs(fine[n] - coarse[n]));
      largest = std::max(largest, std::abs(fine[n]));
    }
    CAPTURE(scene.name);
    CHECK(most < 1e-6 * largest);
  }
}

TEST_CASE("friction: turns no motion round, where it falls a thousand times within a frame", "[physics]") {
  // 0.1 g on a belt of 0.1 m/s; the friction falls from 0.8 to 0.1 N within 5 mm/s. The rate of stick and
  // slip by the integration of the test above in 2048 parts a frame: 1043.59 Hz.
  auto elements = block(1e-4, 20e3, 0.001);
  elements.frictions = {rub(kBelt, kBlock, {0.1, {{{0.7, 0.005}, {}}}}, 1)};
  const auto solver = GENERATE(Solver::Explicit, Solver::Passive, Solver::Implicit, Solver::Exact);
  const int steps = GENERATE(1, 2, 4, 8, 16, 64);
  CAPTURE(static_cast<int>(solver), steps);
  const auto network = Network::make(elements, 2, 48_kHz, solver, steps).value();
  auto state = network.initial_state();
  double before = 0.0, first = 0.0, last = 0.0;
  int rises = 0;
  for (int n = 0; n < 4800; ++n) {
    const double inputs[] = {0.1 * n / 48e3, 1.0};
    network.step(state, inputs);
    const double above = network.position(state, kBlock) - 20e-6;
    if (n > 1200 && before < 0.0 && above >= 0.0) {
      last = n - 1 + before / (before - above);
      if (rises++ == 0) first = last;
    }
    before = above;
  }
  REQUIRE(rises > 50);
  // Within a frame of 46 in each period, and from 16 steps a frame on a tenth of that.
  CHECK(48e3 * (rises - 1) / (last - first) == Approx(1043.59).epsilon(steps < 16 ? 6e-3 : 2e-4));
}
