#include <catch2/catch.hpp>
#include <cmath>

#include "engine/nodes/mechanics/terrain_kernel.h"
#include "engine/nodes/mechanics/virtual_force_kernel.h"

TEST_CASE("mechanics: spring and damper act against displacement and velocity", "[dsp]") {
  CHECK(tactus_spring_force(0.03, 200, 0.01) == Approx(-4));
  CHECK(tactus_damper_force(2, 0.5) == -1);
}

TEST_CASE("mechanics: a wall pushes and never pulls", "[dsp]") {
  const auto force = [](double x, double v) { return tactus_wall_force(x, v, 800, 2, 0.01); };
  CHECK(force(0.012, 0.1) == Approx(-(800 * 0.002 + 2 * 0.1)));
  CHECK(force(0.012, -10) == 0);  // leaving fast: the damper would pull by 18.4 N
  CHECK(force(0.010, 5) == 0);
  CHECK(force(-1, 100) == 0);
}

TEST_CASE("terrain: a detent's peak force 0.60653 k s lies at one s from its centre", "[dsp]") {
  const double depth = 0.001, sigma = 0.002, weight = 3;
  const double stiffness = weight * depth / (sigma * sigma);
  const auto detent = [=](double x) { return tactus_terrain_detent(x, depth, sigma); };
  CHECK(tactus_terrain_force(weight, detent(sigma).slope) ==
        Approx(-std::exp(-0.5) * stiffness * sigma).epsilon(1e-14));
  CHECK(detent(sigma).curvature == Approx(0).margin(1e-12));
  const double x = 0.0007;
  CHECK(tactus_terrain_force(weight, detent(x).slope) ==
        Approx(-stiffness * x * std::exp(-x * x / (2 * sigma * sigma))).epsilon(1e-14));
}

TEST_CASE("terrain: a sine's force and largest stiffness", "[dsp]") {
  const double height = 0.0005, length = 0.003, weight = 2, k = 2 * 3.14159265358979323846 / length;
  const auto sine = [=](double x) { return tactus_terrain_sine(x, height, length); };
  CHECK(tactus_terrain_force(weight, sine(0.0011).slope) ==
        Approx(weight * height * k * std::sin(k * 0.0011)).epsilon(1e-13));
  CHECK(weight * sine(length / 2).curvature ==
        Approx(4 * 9.869604401089358 * weight * height / (length * length)));
}
