#include "engine/dsp/curves/mechanics.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "engine/dsp/curves/terrain.h"

using namespace tactus;

TEST_CASE("mechanics: spring and damper act against displacement and velocity", "[dsp]") {
  CHECK(spring_force(0.03, 200, 0.01) == Approx(-4));
  CHECK(damper_force(2, 0.5) == -1);
}

TEST_CASE("mechanics: a wall pushes and never pulls", "[dsp]") {
  const Wall wall{.stiffness_n_per_m = 800, .damping_n_s_per_m = 2, .at_m = 0.01};
  CHECK(wall.force(0.012, 0.1) == Approx(-(800 * 0.002 + 2 * 0.1)));
  CHECK(wall.force(0.012, -10) == 0);  // leaving fast: the damper would pull by 18.4 N
  CHECK(wall.force(0.010, 5) == 0);
  CHECK(wall.force(-1, 100) == 0);
}

TEST_CASE("terrain: a detent's peak force 0.60653 k s stands at one s from its centre", "[dsp]") {
  const double depth = 0.001, sigma = 0.002, weight = 3;
  const double stiffness = weight * depth / (sigma * sigma);
  const DetentProfile detent{depth, sigma};
  CHECK(terrain_force(weight, detent.slope(sigma)) ==
        Approx(-std::exp(-0.5) * stiffness * sigma).epsilon(1e-14));
  CHECK(detent.curvature(sigma) == Approx(0).margin(1e-12));
  const double x = 0.0007;
  CHECK(terrain_force(weight, detent.slope(x)) ==
        Approx(-stiffness * x * std::exp(-x * x / (2 * sigma * sigma))).epsilon(1e-14));
}

TEST_CASE("terrain: a sine's force and largest stiffness", "[dsp]") {
  const double height = 0.0005, length = 0.003, weight = 2, k = 2 * 3.14159265358979323846 / length;
  const SineProfile sine{height, length};
  CHECK(terrain_force(weight, sine.slope(0.0011)) ==
        Approx(weight * height * k * std::sin(k * 0.0011)).epsilon(1e-13));
  CHECK(weight * sine.curvature(length / 2) ==
        Approx(4 * 9.869604401089358 * weight * height / (length * length)));
}
