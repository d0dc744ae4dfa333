#include "engine/study/walls/virtual_wall.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "engine/core/find_root.h"
#include "tests/support/wall_theory.h"

using namespace tactus;
using namespace tactus::test;

namespace {

constexpr WallDevice kHandle{.mass = 0.05, .damping = 0.1};

/// The border by bisection on the largest root of the companion matrix.
double border_by_roots(const WallDevice& device, const WallLoop& loop, double about) {
  return root_between(0.2 * about, 5 * about,
                      [&](double stiffness) { return largest_root(device, loop, stiffness) - 1; });
}

auto within(double expected, double part) { return Approx(expected).epsilon(0).margin(part * expected); }

}  // namespace

TEST_CASE("held_mass: two half steps are one whole step, with and without damping", "[analysis]") {
  for (const double damping : {0.0, 1e-9, 0.3, 50.0, 4e4}) {
    INFO("damping " << damping);
    const auto half = HeldMass::over(0.02, damping, 0.5e-3), whole = HeldMass::over(0.02, damping, 1e-3);
    CHECK(half.keep * half.keep == Approx(whole.keep).epsilon(1e-12).margin(1e-300));
    CHECK(half.reach * (1 + half.keep) == Approx(whole.reach).epsilon(1e-12));
    CHECK(half.gain * (1 + half.keep) == Approx(whole.gain).epsilon(1e-12));
    CHECK(2 * half.rise + half.reach * half.gain == Approx(whole.rise).epsilon(1e-12));
  }
  const auto free = HeldMass::over(0.02, 0, 1e-3);
  CHECK(free.rise == Approx(0.5 * 1e-6 / 0.02).epsilon(1e-15));  // t^2 / 2m
}

// The paper's table 2 on a handle of 50 g and 0.1 N s/m: K = b / (T/2 + tau_d).
TEST_CASE("virtual_wall: the controllers of the paper reach these walls on a light handle", "[analysis]") {
  struct Row {
    Hertz rate;
    Seconds delay;
    double stiffness;
  };
  for (const Row& row :
       {Row{20_kHz, Seconds{50e-6}, 1333.3}, Row{1_kHz, 1_ms, 66.67}, Row{40_kHz, Seconds{20e-6}, 3076.9},
        Row{40_kHz, Seconds{25e-6}, 2666.7}, Row{96_kHz, 10_ms, 9.9948}, Row{96_kHz, 4_ms, 24.967},
        Row{44.1_kHz, 20_ms, 4.9972}}) {
    INFO(row.rate.value << " Hz, " << row.delay.value << " s");
    const WallLoop loop{row.rate, row.delay};
    CHECK(stiffest_by_damping(kHandle, loop) == within(row.stiffness, 1e-4));
    // b tau / m = 1.5e-4 to 0.04: what the formula neglects is up to a sixth of that.
    CHECK(wall_border(kHandle, loop).stiffness == within(row.stiffness, 0.01));
    CHECK(stiffest_passive(kHandle, loop) == Approx(stiffest_by_damping(kHandle, loop)));
  }
}

TEST_CASE("virtual_wall: the exact border is (b + B) / (T/2 + delay) for slow devices, within 1 %",
          "[analysis]") {
  const double frames = GENERATE(0.0, 0.4, 1.0, 3.0, 20.0, 300.0);
  const double own = GENERATE(0.1, 1.0), virtual_part = GENERATE(0.0, 0.5, 1.0);
  INFO(frames << " frames, b " << own << ", B of b " << virtual_part);
  // The rate at which (b + B) (T/2 + tau_d) / m is 0.004.
  const double damping = own * (1 + virtual_part);
  const Hertz rate{damping * (0.5 + frames) / (0.004 * 0.05)};
  const WallDevice device{.mass = 0.05, .damping = own};
  const WallLoop loop{rate, Seconds{frames / rate.value}, own * virtual_part};
  CHECK(wall_border(device, loop).stiffness == within(stiffest_by_damping(device, loop), 0.01));
}

TEST_CASE("virtual_wall: where the loop is fast, the exact border is that of a pure delay for any damping",
          "[analysis]") {
  const double ratio = GENERATE(1e-4, 0.1, 0.5, 1.0, 10.0, 100.0);
  const WallDevice device{.mass = 0.05, .damping = 2};
  const Seconds lag{ratio * device.mass / device.damping};
  const Hertz rate{2000 / lag.value};
  const WallLoop loop{rate, lag - Seconds{0.5 / rate.value}};
  const auto border = wall_border(device, loop);
  CHECK(border.stiffness == within(stiffest_behind_delay(device, lag), 1e-4));
  // It swings at phi / tau: K sin phi = b phi / tau.
  const double phi = 2 * std::numbers::pi * border.frequency.value * lag.value;
  CHECK(border.stiffness * std::sin(phi) == within(device.damping * phi / lag.value, 1e-3));
}

// Numbers of the solution: x tan x = c, then x / sin x.
TEST_CASE("virtual_wall: the factor over b / tau grows from 1 to a quarter turn", "[analysis]") {
  const auto factor = [](double ratio) {
    const WallDevice device{.mass = 1, .damping = ratio};
    return stiffest_behind_delay(device, 1_s) / ratio;
  };
  CHECK(factor(1e-6) == Approx(1.0).epsilon(0).margin(1e-6));
  CHECK(factor(0.1) == Approx(1.0163).epsilon(0).margin(5e-5));
  CHECK(factor(0.5) == Approx(1.0748).epsilon(0).margin(5e-5));
  CHECK(factor(1) == Approx(1.1349).epsilon(0).margin(5e-5));
  CHECK(factor(10) == Approx(1.4434).epsilon(0).margin(5e-5));
  CHECK(factor(1e6) == Approx(std::numbers::pi / 2).epsilon(0).margin(1e-5));
  CHECK(stiffest_behind_delay({.mass = 1, .damping = 0}, 1_s) == 0);
}

TEST_CASE("virtual_wall: without delay the formula of the two roots is exact, and near 2 b / T",
          "[analysis]") {
  const double ratio = GENERATE(1e-9, 1e-4, 0.01, 0.3, 3.0);  // b T / m
  const WallDevice device{.mass = 0.05, .damping = ratio * 0.05 * 1000};
  CHECK(wall_border(device, {1_kHz}).stiffness == within(stiffest_undelayed(device, 1_kHz), 1e-6));
  if (ratio <= 0.01) CHECK(stiffest_undelayed(device, 1_kHz) == within(2 * device.damping * 1000, ratio));
  // As the formula is written.
  const double p = std::exp(-ratio), a = ratio * 1000;
  if (ratio >= 0.01)
    CHECK(stiffest_undelayed(device, 1_kHz) ==
          within(device.damping * (1 - p) / ((1 - p) / a - p * 1e-3), 1e-9));
}

TEST_CASE("wall_border: bisection on the largest root finds the same border", "[analysis]") {
  const double frames = GENERATE(0.0, 0.3, 1.0, 2.75, 7.0, 40.0);
  const double ratio = GENERATE(1e-3, 0.05, 1.0), virtual_part = GENERATE(0.0, 0.3);
  INFO(frames << " frames, b T / m = " << ratio << ", B of b " << virtual_part);
  const WallDevice device{.mass = 0.05, .damping = ratio * 0.05 * 1000};
  const WallLoop loop{1_kHz, Seconds{frames / 1000}, virtual_part * device.damping};
  const double border = wall_border(device, loop).stiffness;
  REQUIRE(border > 0);
  CHECK(border == within(border_by_roots(device, loop, border), 1e-6));
}

TEST_CASE("wall_border: roots lie inside the circle below it and outside above it", "[analysis]") {
  const double frames = GENERATE(0.0, 0.5, 1.0, 30.0);
  const WallLoop loop{1_kHz, Seconds{frames / 1000}};
  const double border = wall_border(kHandle, loop).stiffness;
  for (const double part : {0.01, 0.1, 0.5, 0.9, 0.99}) CHECK(largest_root(kHandle, loop, part * border) < 1);
  for (const double part : {1.01, 1.1, 2.0, 10.0}) CHECK(largest_root(kHandle, loop, part * border) > 1);
}

TEST_CASE("wall_border: damping of its own helps a wall until it explodes alone", "[analysis]") {
  const WallDevice device{.mass = 0.05, .damping = 0.1};
  const auto border = [&](double damping) { return wall_border(device, {1_kHz, 1_ms, damping}).stiffness; };
  CHECK(border(0.5) > 5 * border(0));
  // It acts for a step T on what was one step ago: unstable where B T / m > 1, less b's help.
  CHECK(border(100) == 0);
  CHECK(largest_root(device, {1_kHz, 1_ms, 100}, 1e-6) > 1);
  CHECK(border(-0.1) == 0);
  CHECK(border(-0.05) == within(0.5 * border(0), 0.01));
  // Passivity sees it the other way round.
  CHECK(stiffest_passive(device, {1_kHz, 1_ms, 0.04}) ==
        within(0.6 * stiffest_passive(device, {1_kHz, 1_ms}), 1e-9));
  CHECK(stiffest_passive(device, {1_kHz, 1_ms, 0.2}) == 0);
}

// Re{(1 - e^-jt) H} at all frequencies, as Colgate and Schenkel write it.
TEST_CASE("virtual_wall: the passive limit holds at every frequency and is reached at the lowest",
          "[analysis]") {
  const int frames = GENERATE(0, 1, 5);
  const WallLoop loop{1_kHz, Seconds{frames / 1000.0}};
  const double stiffness = stiffest_passive(kHandle, loop);
  const auto needed = [&](double t) {
    return 0.5e-3 / (1 - std::cos(t)) * stiffness * (std::cos(frames * t) - std::cos((frames + 1) * t));
  };
  for (int i = 1; i <= 1000; ++i) CHECK(needed(i * std::numbers::pi / 1000) <= kHandle.damping * (1 + 1e-9));
  CHECK(needed(1e-3) == within(kHandle.damping, 1e-4));
}

TEST_CASE("virtual_wall: dry friction and steps", "[analysis]") {
  // A servo arm of 10 cm with 4000 counts a turn and 0.2 N of friction.
  CHECK(stiffest_by_friction({.friction = 0.2, .quantum = 2 * std::numbers::pi * 0.1 / 4000}) ==
        within(2546.5, 1e-4));
  CHECK(std::isinf(stiffest_by_friction({.friction = 0.2})));
}

TEST_CASE("virtual_wall: the cycle around an encoder's edge is that of a relay", "[analysis]") {
  const WallDevice device{.mass = 0.05, .damping = 0.5, .quantum = 0.157e-3};
  const auto cycle = encoder_edge_cycle(device, 100, Seconds{2.05e-3});
  REQUIRE(cycle);
  CHECK(cycle->frequency.value == Approx(10.230).epsilon(0).margin(5e-4));
  CHECK(cycle->counts == Approx(0.2957).epsilon(0).margin(5e-5));
  // The describing function of a relay, for small b tau / m: w = sqrt(b / (m tau)), (2/pi) K tau / b.
  const WallDevice slow{.mass = 50, .damping = 0.5, .quantum = 1e-3};
  const auto wide = encoder_edge_cycle(slow, 10, 1_ms);
  CHECK(2 * std::numbers::pi * wide->frequency.value == within(std::sqrt(0.5 / (50 * 1e-3)), 0.11));
  CHECK(wide->counts == within(2 / std::numbers::pi * 10 * 1e-3 / 0.5, 0.25));
  auto rough = device;
  rough.friction = 0.5 * 100 * device.quantum;
  CHECK_FALSE(encoder_edge_cycle(rough, 100, Seconds{2.05e-3}));
}

TEST_CASE("virtual_wall: the amplitude at which a cut spring comes to rest", "[analysis]") {
  // Half of the stiffness is left at r = 2.4753: (2/pi) (asin(1/r) + sqrt(1 - 1/r^2) / r) = 1/2.
  CHECK(cut_cycle_amplitude(2000, 1000, 4) == within(2.4753 * 4 / 2000, 1e-3));
  CHECK(cut_cycle_amplitude(1000.001, 1000, 4) == within(4e-3, 1e-3));  // hardly cut
  // Far above the border the force is a square wave: 4 F / pi = K_border x.
  CHECK(cut_cycle_amplitude(1e6, 1000, 4) == within(4 / std::numbers::pi * 4 / 1000, 1e-3));
}
