#include "engine/study/walls/wall_simulation.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <vector>

#include "engine/study/walls/virtual_wall.h"
#include "tests/support/rough_wall.h"
#include "tests/support/wall_theory.h"

using namespace tactus;
using namespace tactus::test;

namespace {

auto within(double expected, double part) { return Approx(expected).epsilon(0).margin(part * expected); }

struct Swing {
  double frequency_hz, amplitude;
};
/// Over the time after `skip`: upward passages of `middle` by time, half of peak to peak.
Swing swing_of(auto& simulation, Hertz rate, double skip_s, double listen_s, double middle) {
  for (double n = 0; n < skip_s * rate.value; ++n) simulation.step();
  double before = simulation.position(), low = before, high = before, first = -1, last = -1;
  int passages = 0;
  for (double n = 1; n <= listen_s * rate.value; ++n) {
    simulation.step();
    const double now = simulation.position();
    if (before < middle && now >= middle) {
      last = n - (now - middle) / (now - before);
      if (passages++ == 0) first = last;
    }
    low = std::min(low, now);
    high = std::max(high, now);
    before = now;
  }
  const double cycle = passages > 1 ? (last - first) / (passages - 1) : 0;
  return {cycle > 0 ? rate.value / cycle : 0, 0.5 * (high - low)};
}

}  // namespace

TEST_CASE("wall_simulation: without a force it flies and slows as the exact solution says", "[analysis]") {
  WallSimulation simulation{
      {.device = {.mass = 0.02, .damping = 0.4}, .loop = {1_kHz, Seconds{0.4e-3}}}, 0.1, 2};
  for (int n = 0; n < 100; ++n) simulation.step();
  const double kept = std::exp(-0.4 / 0.02 * 0.1);
  CHECK(simulation.velocity() == Approx(2 * kept).epsilon(1e-12));
  CHECK(simulation.position() == Approx(0.1 + 2 * 0.02 / 0.4 * (1 - kept)).epsilon(1e-12));
}

TEST_CASE("rough_wall: dry friction stops it where its energy is spent, and holds it there", "[analysis]") {
  const double damping = GENERATE(0.0, 0.3);
  RoughWall simulation{{.mass = 0.02, .damping = damping, .friction = 0.5}, {}, 0, 0.4, 0, 1};
  for (int n = 0; n < 20000; ++n) simulation.step();
  CHECK(simulation.velocity() == 0);
  // m v dv/dx = -(0.1 N + b v), from 1 m/s to rest.
  const double left = 0.1;
  const double way =
      damping == 0 ? 0.02 / (2 * left) : 0.02 / damping * (1 - left / damping * std::log1p(damping / left));
  CHECK(simulation.position() == Approx(way).epsilon(1e-9));
}

TEST_CASE("wall_simulation: a spring of 0.99 of the border decays, one of 1.01 grows", "[analysis]") {
  const double frames = GENERATE(0.0, 0.4, 1.0, 8.0, 100.0);
  const double damping = GENERATE(0.1, 3.0), virtual_part = GENERATE(0.0, 0.4);
  INFO(frames << " frames, b " << damping << ", B of b " << virtual_part);
  WallRun run{.device = {.mass = 0.05, .damping = damping},
              .loop = {4_kHz, Seconds{frames / 4000}, virtual_part * damping}};
  const auto border = wall_border(run.device, run.loop);
  REQUIRE(border.stiffness > 0);
  const auto trend = [&](double part) {
    run.stiffness = part * border.stiffness;
    return trend_of(WallSimulation{run, 1e-3, 0}, border.frequency, run.loop.rate);
  };
  CHECK(trend(0.99) == LoopTrend::Decays);
  CHECK(trend(1.01) == LoopTrend::Grows);
}

TEST_CASE("wall_simulation: a loop that neither grows nor decays in time is undecided", "[analysis]") {
  WallRun run{.device = {.mass = 0.05, .damping = 0.5}, .loop = {4_kHz, 1_ms}};
  const auto border = wall_border(run.device, run.loop);
  run.stiffness = border.stiffness;
  CHECK(trend_of(WallSimulation{run, 1e-3, 0}, border.frequency, run.loop.rate, 1e6) == LoopTrend::Undecided);
}

// A hand leans with half the force of a count. Sampling adds half a frame of doubt to the delay of 41 halves.
TEST_CASE("rough_wall: an encoder's edge keeps a leaning hand trembling at 10.23 Hz", "[analysis]") {
  WallDevice device{.mass = 0.05, .damping = 0.5, .quantum = 0.157e-3};
  const WallLoop loop{10_kHz, 2_ms};
  const double stiffness = 100, push = 0.5 * stiffness * device.quantum, edge = 0.5 * device.quantum;
  const auto exact = encoder_edge_cycle(device, stiffness, Seconds{loop.lag()});
  RoughWall simulation{device, loop, stiffness, push, edge + 0.2 * device.quantum};
  const auto swing = swing_of(simulation, loop.rate, 5, 5, edge);
  CHECK(swing.frequency_hz == within(exact->frequency.value, 0.02));
  CHECK(swing.amplitude / device.quantum == within(exact->counts, 0.03));

  // Friction of half a count's force ends it: what is left is where it was put down.
  device.friction = push;
  RoughWall rough{device, loop, stiffness, push, edge + 0.2 * device.quantum};
  CHECK(swing_of(rough, loop.rate, 5, 1, edge).amplitude == 0);
}

TEST_CASE("rough_wall: where K <= min(2b/T, 2f_c/Delta) every disturbance dies, without it not",
          "[analysis]") {
  const double counts = GENERATE(0.7, 1.2, 3.0, 12.0);
  const WallLoop loop{1_kHz};
  const double quantum = 0.157e-3, stiffness = 1000;
  const auto left_over = [&](double damping, double friction) {
    const WallDevice device{.mass = 0.05, .damping = damping, .friction = friction, .quantum = quantum};
    RoughWall simulation{device, loop, stiffness, 0, counts * quantum};
    return swing_of(simulation, loop.rate, 4, 1, 0).amplitude / quantum;
  };
  const double damping = 0.5 * stiffness * loop.period();
  const double friction = 0.5 * stiffness * quantum;
  CHECK(left_over(damping, friction) == 0);
  if (counts > 1) CHECK(left_over(0, 0.1 * friction) > 10);
}

TEST_CASE("wall_simulation: above the border it grows until the motor's limit and rests there",
          "[analysis]") {
  struct Case {
    double above, part;
  };
  // The describing function leaves out what the delay makes of the harmonics: more, the squarer the force.
  const auto given = GENERATE(Case{1.05, 0.01}, Case{1.2, 0.025}, Case{2.0, 0.07}, Case{5.0, 0.13});
  WallRun run{.device = {.mass = 0.05, .damping = 0.5, .force_limit = 6.37}, .loop = {10_kHz, 1_ms}};
  const double border = wall_border(run.device, run.loop).stiffness;
  run.stiffness = given.above * border;
  WallSimulation simulation{run, 1e-2, 0};
  const auto swing = swing_of(simulation, run.loop.rate, 30, 2, 0);
  CHECK(swing.amplitude == within(cut_cycle_amplitude(run.stiffness, border, 6.37), given.part));
}

TEST_CASE("wall_simulation: far above the border it swings like a relay with the motor's force",
          "[analysis]") {
  WallRun run{.device = {.mass = 0.05, .damping = 0.5, .force_limit = 6.37}, .loop = {10_kHz, 1_ms}};
  run.stiffness = 100 * wall_border(run.device, run.loop).stiffness;
  WallSimulation simulation{run, 1e-5, 0};
  const auto swing = swing_of(simulation, run.loop.rate, 10, 2, 0);
  // An encoder whose one step is 1 m, with a force of 2 F_max for it.
  const auto relay =
      encoder_edge_cycle({.mass = 0.05, .damping = 0.5, .quantum = 1}, 2 * 6.37, Seconds{run.loop.lag()});
  CHECK(swing.amplitude == within(relay->counts, 0.01));
  CHECK(swing.frequency_hz == within(relay->frequency.value, 0.01));
}

TEST_CASE("wall_simulation: whole numbers of 16 bits round the stiffness, and nothing else that can be felt",
          "[analysis]") {
  const double quantum = 2 * std::numbers::pi * 0.1 / 4000;
  WallRun run{.device = {.mass = 0.05, .damping = 0.1, .quantum = quantum, .force_limit = 6.37},
              .loop = {20_kHz, Seconds{50e-6}},
              .stiffness = 1000};
  const auto demanded_at = [&](double counts, int bits) {
    run.bits = bits;
    WallSimulation simulation{run, counts * quantum, 0};
    for (int frame = 0; frame < 2; ++frame) simulation.step();  // a frame of delay
    return simulation.velocity() / HeldMass::over(0.05, 0.1, run.loop.period()).gain;
  };
  const double step = 6.37 / 32768, per_count = std::round(1000 * quantum / step);
  CHECK(demanded_at(7, 16) == Approx(-7 * per_count * step).epsilon(1e-12));
  CHECK(demanded_at(7, 16) == within(demanded_at(7, 0), -0.5 / per_count));
  CHECK(demanded_at(-500, 16) == Approx(6.37 - step));  // full scale, one step short
  CHECK(demanded_at(500, 16) == Approx(-6.37));
  // Eight bits cannot: a count is worth three steps or four.
  CHECK(std::abs(demanded_at(7, 8) / demanded_at(7, 0) - 1) > 0.04);
}
