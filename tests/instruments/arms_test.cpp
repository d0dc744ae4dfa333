#include <catch2/catch.hpp>
#include <cmath>
#include <string>
#include <vector>

#include "engine/study/stability/stability.h"
#include "engine/study/walls/virtual_wall.h"
#include "tests/support/shipped_scene.h"

// Walls through arms: the stiffest one by `tactus check` against the formula of one axis.

using namespace tactus;
using test::kInstruments;

namespace {

/// An arm as its plant has it: at its start, the slope of the wall's coordinate by each joint, and the
/// inertia and the damping of each joint.
struct WallArm {
  std::string folder;
  std::vector<double> slopes, inertia, damping;

  /// As felt across the wall, where all joints have damping in proportion to inertia: 1 / (j^T M^-1 j).
  WallDevice device() const {
    double mass = 0, damper = 0;
    for (std::size_t joint = 0; joint < slopes.size(); ++joint) {
      mass += slopes[joint] * slopes[joint] / inertia[joint];
      damper += slopes[joint] * slopes[joint] / damping[joint];
    }
    return {.mass = 1 / mass, .damping = 1 / damper};
  }
};

constexpr double kDegree = 3.14159265358979323846 / 180;

/// dy/dq of two links of 15 cm at 30 and 90 degrees.
WallArm two_link() {
  const double first = 0.15 * std::cos(30 * kDegree), second = 0.15 * std::cos(120 * kDegree);
  return {"two_link", {first + second, second}, {3e-4, 3e-4}, {1.5e-3, 1.5e-3}};
}

/// A pantograph at 125 and 55 degrees: y = link_1 sin q + sqrt(link_2^2 - (base/2 + link_1 cos q)^2) where
/// both move alike; by symmetry each motor has half of that slope.
WallArm five_bar() {
  const double c = std::cos(55 * kDegree), s = std::sin(55 * kDegree), half = 0.0125 + 0.063 * c;
  const double slope = 0.063 * c + half * 0.063 * s / std::sqrt(0.075 * 0.075 - half * half);
  return {"five_bar", {-0.5 * slope, 0.5 * slope}, {8e-5, 8e-5}, {4e-4, 4e-4}};
}

/// A delta at 30 degrees: z = link_1 sin q + sqrt(link_2^2 - (base + link_1 cos q)^2), a third of it each.
WallArm delta() {
  const double c = std::cos(30 * kDegree), s = std::sin(30 * kDegree), out = 0.0226 + 0.06 * c;
  const double slope = (0.06 * c + out * 0.06 * s / std::sqrt(0.1025 * 0.1025 - out * out)) / 3;
  return {"delta", {slope, slope, slope}, {1e-4, 1e-4, 1e-4}, {5e-4, 5e-4, 5e-4}};
}

/// Six axes, the pen straight down over the floor: dz/dq of shoulder and elbow; the gimbal does not lift it.
WallArm six_axis() {
  const double fore = 0.133 * std::cos(-30 * kDegree), reach = 0.133 * std::cos(60 * kDegree) + fore;
  return {"six_axis", {reach, fore}, {8e-4, 8e-4}, {4e-3, 4e-3}};
}

}  // namespace

TEST_CASE("arms: the stiffest wall of the check is that of one axis with the mass and damping at the tip",
          "[instruments][slow]") {
  const auto arm = GENERATE(two_link(), five_bar(), delta(), six_axis());
  INFO(arm.folder);
  const auto scene = load_scene_leniently(kInstruments / "arms" / arm.folder / "bare.toml", kInstruments);
  REQUIRE(scene.errors.empty());
  StabilityOptions options;
  const auto verdict = analyse_stability({&scene, nullptr, &standard_nodes()}, options);
  REQUIRE(verdict);
  CHECK(verdict->stable());
  double stiffest = 0;
  for (const auto& regime : verdict->regimes)
    for (const auto& stiff : regime.stiff)
      if (!regime.held && stiff.stiffness > 0) stiffest = stiff.stable_up_to;
  const auto border = wall_border(arm.device(), {scene.scene->rate, scene.scene->delay});
  // The arm comes to rest after some 50 ms of its throw, when the pose is another one.
  CHECK(stiffest == Approx(border.stiffness).epsilon(0.01));
}
