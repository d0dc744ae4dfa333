#include <fmt/format.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "engine/study/walls/virtual_wall.h"
#include "tests/support/graphs/graph_runner.h"
#include "tests/support/wall_theory.h"

// Virtual walls as graph files play them: the nodes, their order and their delays against the theory of
// sampled walls.

using namespace tactus;

namespace {

auto within(double expected, double part) { return Approx(expected).epsilon(0).margin(part * expected); }

/// A device under a force from nodes.
struct Loop {
  WallDevice device;
  Hertz rate = 10_kHz;
  int frames_of_delay = 0;
  std::string force = {};  ///< nodes, of which `pull` is the force; `x` is the position, `v` the velocity
  double push = 0, start = 0, velocity = 0;

  WallLoop loop(double damping = 0) const { return {rate, Seconds{frames_of_delay / rate.value}, damping}; }
  /// Position and force on the device, frame by frame.
  test::Channels play(double seconds) const {
    const auto text = fmt::format(
        "format = 1\n[networks.arm]\nframe = {{ type = \"ground\" }}\n"
        "tip = {{ type = \"mass\", mass = {}, at = {}, velocity = {} }}\n"
        "bearing = {{ type = \"damper\", between = [\"frame\", \"tip\"], damping = {} }}\n"
        "motor = {{ type = \"force\", on = \"tip\", force = \"drive + {}\" }}\n"
        "[nodes]\nx = \"arm.tip.position\"\nv = {{ type = \"difference\", in = \"x\" }}\n{}\n"
        "drive = {{ type = \"delay\", in = \"pull\", time = {}, interpolation = \"none\" }}\n"
        "[outputs]\nposition = {{ from = \"x\", unit = \"m\" }}\nforce = {{ from = \"drive\", unit = \"N\" "
        "}}\n",
        device.mass, start, velocity, device.damping, push, force, frames_of_delay / rate.value);
    CompileOptions options;
    options.sample_rate = rate;
    const auto engine = test::engine_of(text, options);
    return test::run(*engine, {}, static_cast<int>(seconds * rate.value), {256});
  }
};

double sum_of_squares(const std::vector<double>& x, Hertz rate, double from_s, double to_s, double middle) {
  double sum = 0;
  for (auto n = static_cast<std::size_t>(from_s * rate.value);
       n < static_cast<std::size_t>(to_s * rate.value); ++n)
    sum += (x[n] - middle) * (x[n] - middle);
  return sum;
}

double amplitude(const std::vector<double>& x, std::size_t from) {
  const auto [low, high] = std::minmax_element(x.begin() + static_cast<std::ptrdiff_t>(from), x.end());
  return 0.5 * (*high - *low);
}

/// From the first upward passage of `middle` to the last.
double frequency(const std::vector<double>& x, Hertz rate, std::size_t from, double middle) {
  double first = -1, last = -1;
  int passages = 0;
  for (auto n = from + 1; n < x.size(); ++n) {
    if (x[n - 1] >= middle || x[n] < middle) continue;
    last = static_cast<double>(n) - (x[n] - middle) / (x[n] - x[n - 1]);
    if (passages++ == 0) first = last;
  }
  return rate.value * (passages - 1) / (last - first);
}

std::string spring_of(double stiffness) {
  return fmt::format("pull = {{ type = \"spring\", in = \"x\", stiffness = {} }}", stiffness);
}

}  // namespace

TEST_CASE("wall loop: a spring grows or dies on either side of its border, 1 % off", "[nodes]") {
  const int frames = GENERATE(0, 1, 2, 17);
  Loop loop{.device = {.mass = 0.05, .damping = 2}, .frames_of_delay = frames, .start = 1e-3};
  const auto border = wall_border(loop.device, loop.loop());
  INFO(frames << " frames, border " << border.stiffness << " N/m at " << border.frequency.value << " Hz");
  const auto growth = [&](double part) {
    loop.force = spring_of(part * border.stiffness);
    const auto x = loop.play(8)[0];
    return sum_of_squares(x, loop.rate, 7, 8, 0) / sum_of_squares(x, loop.rate, 1, 2, 0);
  };
  // The root moves by about a hundredth of b / 2m = 20/s: e^(2 0.2 6) = 11.
  CHECK(growth(1.01) > 4);
  CHECK(growth(0.99) < 0.25);
}

TEST_CASE("wall loop: a wall on which a finger leans has the border of its spring and damper", "[nodes]") {
  const double damping = GENERATE(0.0, 1.0);
  Loop loop{.device = {.mass = 0.05, .damping = 2}, .frames_of_delay = 2, .push = 1};
  const auto border = wall_border(loop.device, loop.loop(damping));
  const auto growth = [&](double part) {
    const double stiffness = part * border.stiffness, depth = 1 / stiffness;
    loop.start = 1.05 * depth;
    loop.force = fmt::format(
        "pull = {{ type = \"wall\", position = \"x\", velocity = \"v\", stiffness = {}, damping = {} }}",
        stiffness, damping);
    const auto x = loop.play(8)[0];
    return sum_of_squares(x, loop.rate, 7, 8, depth) / sum_of_squares(x, loop.rate, 1, 2, depth);
  };
  CHECK(growth(1.01) > 4);
  CHECK(growth(0.99) < 0.25);
}

TEST_CASE("wall loop: an encoder's edge keeps a leaning hand trembling at 10.23 Hz", "[nodes]") {
  const double quantum = 0.157e-3, stiffness = 100;
  Loop loop{.device = {.mass = 0.05, .damping = 0.5, .quantum = quantum}, .frames_of_delay = 20};
  loop.push = 0.5 * stiffness * quantum;
  loop.start = 0.7 * quantum;  // the edge lies at half a step
  loop.force = fmt::format(
      "read = {{ type = \"quantiser\", in = \"x\", step = {} }}\n"
      "pull = {{ type = \"spring\", in = \"read\", stiffness = {} }}",
      quantum, stiffness);
  const auto x = loop.play(10)[0];
  CHECK(frequency(x, loop.rate, 50000, 0.5 * quantum) == within(10.23, 0.02));
  CHECK(amplitude(x, 50000) / quantum == within(0.2957, 0.03));
}

TEST_CASE("wall loop: a wall without damping throws back what the delay adds", "[nodes]") {
  const int frames = GENERATE(0, 1);
  double mean = 0;
  constexpr int kPhases = 20;
  Loop loop{
      .device = {.mass = 0.05, .damping = 0}, .rate = 1_kHz, .frames_of_delay = frames, .velocity = 0.3};
  loop.force = "pull = { type = \"wall\", position = \"x\", stiffness = \"800 N/m\" }";
  for (int i = 0; i < kPhases; ++i) {
    loop.start = -0.3 * 1e-3 * (i + 0.5) / kPhases;
    const auto x = loop.play(0.2)[0];
    mean += (x[198] - x[199]) / (0.3 * 1e-3) / kPhases;
  }
  CHECK(mean == within(test::wall_rebound(0.05, 800, Seconds{loop.loop().lag()}), 0.01));
}

TEST_CASE("wall loop: above the border the swing grows until the motor's force is cut", "[nodes]") {
  Loop loop{.device = {.mass = 0.05, .damping = 0.5}, .frames_of_delay = 10, .start = 1e-5};
  const double border = wall_border(loop.device, loop.loop()).stiffness, stiffness = 1.2 * border;
  loop.force = fmt::format(
      "asked = {{ type = \"spring\", in = \"x\", stiffness = {} }}\n"
      "pull = {{ type = \"clip\", in = \"asked\", low = \"-6.37 N\", high = \"6.37 N\" }}",
      stiffness);
  const auto out = loop.play(10);
  CHECK(amplitude(out[1], 80000) == Approx(6.37));
  CHECK(amplitude(out[0], 80000) == within(test::cut_cycle_amplitude(stiffness, border, 6.37), 0.025));
}

TEST_CASE("wall loop: a spring behind a delay gives pi K X^2 sin(w tau) in every cycle", "[nodes]") {
  // 50 Hz, 5 ms of delay: a quarter of a cycle, and a fifth of that.
  const double delay_s = GENERATE(5e-3, 1e-3);
  const auto engine = test::engine_of(fmt::format(
      "format = 1\n[nodes]\nx = {{ type = \"sine\", frequency = \"50 Hz\", level = \"2 mm\" }}\n"
      "late = {{ type = \"delay\", in = \"x\", time = {}, interpolation = \"none\" }}\n"
      "pull = {{ type = \"spring\", in = \"late\", stiffness = \"300 N/m\" }}\n"
      "[outputs]\nx = {{ from = \"x\", unit = \"m\" }}\nforce = {{ from = \"pull\", unit = \"N\" }}\n",
      delay_s));
  const auto out = test::run(*engine, {}, 48000, {256});
  double given = 0;
  for (std::size_t n = 9600; n < 48000; ++n)
    given += 0.5 * (out[1][n] + out[1][n - 1]) * (out[0][n] - out[0][n - 1]);
  const double cycles = 0.8 * 50;
  CHECK(given / cycles ==
        within(std::numbers::pi * 300 * 4e-6 * std::sin(2 * std::numbers::pi * 50 * delay_s), 0.01));
}
