#include <Eigen/Geometry>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "tests/support/graphs/play_node.h"

// Arms against geometry: closed forms of poses, and derivatives of what they say of their tip.

using namespace tactus;
using test::refusal;
using test::Samples;

namespace {

constexpr double kTurn = std::numbers::pi;
constexpr double kGravity = 9.80665;
using ArmInputs = std::map<std::string, test::InputValue>;
using ArmSettings = std::map<std::string, std::string>;

/// All outputs by name.
std::map<std::string, Samples> pose(const std::string& arm, const ArmInputs& inputs, int frames = 1,
                                    const ArmSettings& settings = {}) {
  const auto& type = test::node_type(arm);
  test::NodeRunner runner(type, inputs, settings);
  const auto outputs = runner.run(test::even_cutting(frames, test::kLongestSubBlock));
  std::map<std::string, Samples> named;
  for (std::size_t o = 0; o < outputs.size(); ++o) named[type.outputs[o].name] = outputs[o];
  return named;
}

double value(const std::string& arm, const ArmInputs& inputs, const std::string& output) {
  return pose(arm, inputs).at(output)[0];
}

struct TestedArm {
  std::string name;
  int joints, axes;
  /// In the middle of the poses that are tried, and how far they go from there.
  std::vector<double> middle;
  double reach;
  ArmInputs sizes = {};
};

const std::vector<TestedArm>& tested_arms() {
  static const std::vector<TestedArm> arms = {
      {"two_link", 2, 2, {0.4, 1.4}, 0.9, {{"link_1", 0.12}, {"link_2", 0.2}}},
      {"five_bar", 2, 2, {2.2, 0.9}, 0.35},
      {"delta", 3, 3, {0.3, 0.3, 0.3}, 0.4},
      {"six_axis", 6, 3, {0.2, 0.8, -1.4, 0.3, 1.3, 0.5}, 0.5, {{"link_3", 0.07}}}};
  return arms;
}

constexpr int kPoses = 200;

/// Angles at random around the middle, the same for the same seed.
std::vector<Samples> angles_of(const TestedArm& arm, unsigned seed = 1) {
  std::vector<Samples> angles;
  for (int joint = 0; joint < arm.joints; ++joint) {
    const double middle = arm.middle[static_cast<std::size_t>(joint)];
    angles.push_back(
        test::noise(kPoses, seed + static_cast<unsigned>(joint), middle - arm.reach, middle + arm.reach));
  }
  return angles;
}

ArmInputs with_angles(const TestedArm& arm, const std::vector<Samples>& angles) {
  auto inputs = arm.sizes;
  for (int joint = 0; joint < arm.joints; ++joint)
    inputs["angle_" + std::to_string(joint + 1)] = angles[static_cast<std::size_t>(joint)];
  return inputs;
}

const char* const kAxes[] = {"x", "y", "z"};
const char* const kColumns[] = {"pen_", "left_", "up_"};

/// d output / d angle by four points: its error is h^4 f'''''/30, 1e-13 of these arms.
Samples slope(const TestedArm& arm, const std::vector<Samples>& angles, std::size_t joint,
              const std::string& output) {
  constexpr double kStep = 1e-3;
  const auto at = [&](double by) {
    auto there = angles;
    for (auto& angle : there[joint]) angle += by;
    return pose(arm.name, with_angles(arm, there), kPoses).at(output);
  };
  const auto a = at(kStep), b = at(-kStep), c = at(2 * kStep), d = at(-2 * kStep);
  Samples slopes;
  for (std::size_t n = 0; n < a.size(); ++n)
    slopes.push_back((8 * (a[n] - b[n]) - (c[n] - d[n])) / (12 * kStep));
  return slopes;
}

}  // namespace

TEST_CASE("arms: the tip is where geometry has it", "[nodes]") {
  SECTION("two links, bent by a right angle") {
    const ArmInputs inputs{{"angle_1", kTurn / 6}, {"angle_2", kTurn / 2}, {"link_1", 0.3}, {"link_2", 0.2}};
    CHECK(value("two_link", inputs, "x") == Approx(0.3 * std::cos(kTurn / 6) - 0.2 * 0.5).epsilon(1e-14));
    CHECK(value("two_link", inputs, "y") == Approx(0.3 * 0.5 + 0.2 * std::cos(kTurn / 6)).epsilon(1e-14));
  }
  SECTION("five bars, symmetrical: the height over the elbows is that of an isosceles triangle") {
    const double angle = 1.2;
    const ArmInputs inputs{{"angle_1", kTurn - angle}, {"angle_2", angle}};
    const double half = 0.5 * 0.025 + 0.063 * std::cos(angle);
    CHECK(value("five_bar", inputs, "x") == Approx(0).margin(1e-15));
    CHECK(value("five_bar", inputs, "y") ==
          Approx(0.063 * std::sin(angle) + std::sqrt(0.075 * 0.075 - half * half)).epsilon(1e-14));
  }
  SECTION("a delta, symmetrical: on its axis") {
    const double angle = 0.4;
    const ArmInputs inputs{{"angle_1", angle}, {"angle_2", angle}, {"angle_3", angle}};
    const double out = 0.0226 + 0.06 * std::cos(angle);
    CHECK(value("delta", inputs, "x") == Approx(0).margin(1e-15));
    CHECK(value("delta", inputs, "y") == Approx(0).margin(1e-15));
    CHECK(value("delta", inputs, "z") ==
          Approx(0.06 * std::sin(angle) + std::sqrt(0.1025 * 0.1025 - out * out)).epsilon(1e-14));
  }
  SECTION("six axes: upper arm up, forearm level in y, pen straight down") {
    const ArmInputs inputs{{"angle_1", kTurn / 2}, {"angle_2", kTurn / 2},  {"angle_3", -kTurn / 2},
                           {"angle_4", 0.0},       {"angle_5", -kTurn / 2}, {"angle_6", 0.7}};
    const auto at = pose("six_axis", inputs);
    CHECK(at.at("x")[0] == Approx(0).margin(1e-15));
    CHECK(at.at("y")[0] == Approx(0.133).epsilon(1e-14));
    CHECK(at.at("z")[0] == Approx(0.133 - 0.04).epsilon(1e-14));
  }
}

TEST_CASE("arms: the outer links of closed chains keep their length", "[nodes]") {
  const auto& bars = tested_arms()[1];
  const auto angles = angles_of(bars);
  const auto tip = pose("five_bar", with_angles(bars, angles), kPoses);
  const auto& delta = tested_arms()[2];
  const auto turned = angles_of(delta);
  const auto platform = pose("delta", with_angles(delta, turned), kPoses);
  for (std::size_t n = 0; n < kPoses; ++n) {
    for (std::size_t side = 0; side < 2; ++side) {
      const double x = (side == 0 ? -0.0125 : 0.0125) + 0.063 * std::cos(angles[side][n]);
      const double y = 0.063 * std::sin(angles[side][n]);
      REQUIRE(std::hypot(tip.at("x")[n] - x, tip.at("y")[n] - y) == Approx(0.075).epsilon(1e-12));
    }
    for (std::size_t motor = 0; motor < 3; ++motor) {
      const double out = 0.0226 + 0.06 * std::cos(turned[motor][n]);
      const double around = 2 * kTurn * static_cast<double>(motor) / 3;
      REQUIRE(std::hypot(
                  platform.at("x")[n] - out * std::cos(around), platform.at("y")[n] - out * std::sin(around),
                  platform.at("z")[n] - 0.06 * std::sin(turned[motor][n])) == Approx(0.1025).epsilon(1e-12));
    }
  }
}

TEST_CASE("arms: torques are those of the slopes of the tip, J^T F", "[nodes]") {
  const auto& arm = tested_arms()[GENERATE(range(0, 4))];
  INFO(arm.name);
  const auto angles = angles_of(arm);
  for (int axis = 0; axis < arm.axes; ++axis) {
    auto inputs = with_angles(arm, angles);
    inputs[std::string{"force_"} + kAxes[axis]] = 1.0;
    const auto torques = pose(arm.name, inputs, kPoses);
    for (int joint = 0; joint < arm.joints; ++joint) {
      const auto expected = slope(arm, angles, static_cast<std::size_t>(joint), kAxes[axis]);
      const auto& torque = torques.at("torque_" + std::to_string(joint + 1));
      double worst = 0;
      for (std::size_t n = 0; n < expected.size(); ++n)
        worst = std::max(worst, std::abs(torque[n] - expected[n]));
      CHECK(worst < 1e-9);
    }
  }
  const auto conditioning = pose(arm.name, with_angles(arm, angles), kPoses).at("conditioning");
  CHECK(*std::min_element(conditioning.begin(), conditioning.end()) > 0.02);  // none is singular
}

TEST_CASE("six_axis: the orientation of the pen is the product of the rotations of its joints", "[nodes]") {
  const auto& arm = tested_arms()[3];
  const auto angles = angles_of(arm, 5);
  const auto played = pose("six_axis", with_angles(arm, angles), kPoses);
  using Eigen::AngleAxisd;
  using Eigen::Vector3d;
  for (std::size_t n = 0; n < kPoses; ++n) {
    const Eigen::Matrix3d expected =
        (AngleAxisd(angles[0][n], Vector3d::UnitZ()) *
         AngleAxisd(-angles[1][n] - angles[2][n], Vector3d::UnitY()) *
         AngleAxisd(angles[3][n], Vector3d::UnitX()) * AngleAxisd(-angles[4][n], Vector3d::UnitY()) *
         AngleAxisd(angles[5][n], Vector3d::UnitX()))
            .toRotationMatrix();
    for (int column = 0; column < 3; ++column)
      for (int axis = 0; axis < 3; ++axis)
        REQUIRE(played.at(std::string{kColumns[column]} + kAxes[axis])[n] ==
                Approx(expected(axis, column)).margin(1e-14));
  }
}

TEST_CASE("six_axis: a moment on the pen takes the torques of its slopes of orientation", "[nodes]") {
  // R' = w x R column by column, so that w = 1/2 sum of column x column', and torque q' = moment w.
  const auto& arm = tested_arms()[3];
  const auto angles = angles_of(arm, 9);
  const double moment[] = {0.3, -0.2, 0.5};
  auto inputs = with_angles(arm, angles);
  for (std::size_t axis = 0; axis < 3; ++axis) inputs[std::string{"moment_"} + kAxes[axis]] = moment[axis];
  const auto played = pose(arm.name, inputs, kPoses);
  for (std::size_t joint = 0; joint < 6; ++joint) {
    Samples expected(kPoses, 0.0);
    for (const char* column : kColumns)
      for (std::size_t i = 0; i < 3; ++i) {
        const auto &j = kAxes[(i + 1) % 3], &k = kAxes[(i + 2) % 3];
        const auto &at_j = played.at(std::string{column} + j), &at_k = played.at(std::string{column} + k);
        const auto turned_j = slope(arm, angles, joint, std::string{column} + j);
        const auto turned_k = slope(arm, angles, joint, std::string{column} + k);
        for (std::size_t n = 0; n < kPoses; ++n)
          expected[n] += 0.5 * moment[i] * (at_j[n] * turned_k[n] - at_k[n] * turned_j[n]);
      }
    const auto& torque = played.at("torque_" + std::to_string(joint + 1));
    for (std::size_t n = 0; n < kPoses; ++n) REQUIRE(torque[n] == Approx(expected[n]).margin(1e-9));
  }
}

TEST_CASE("arms: what the tip gives the motors take, over a long way", "[nodes]") {
  const auto& arm = tested_arms()[GENERATE(range(0, 4))];
  INFO(arm.name);
  // Simpson's rule: its error is h^4 of the way's curvature, below 1e-10 of the work here.
  constexpr int kIntervals = 2000;
  std::vector<Samples> angles(static_cast<std::size_t>(arm.joints));
  for (std::size_t joint = 0; joint < angles.size(); ++joint)
    for (int n = 0; n <= kIntervals; ++n)
      angles[joint].push_back(arm.middle[joint] +
                              arm.reach * std::sin(2.0 * n / kIntervals + static_cast<double>(joint)));
  auto inputs = with_angles(arm, angles);
  const double force[] = {2.0, -3.0, 1.5};
  for (int axis = 0; axis < arm.axes; ++axis) inputs[std::string{"force_"} + kAxes[axis]] = force[axis];
  const auto played = pose(arm.name, inputs, kIntervals + 1);
  double given = 0, taken = 0;
  for (int axis = 0; axis < arm.axes; ++axis)
    given += force[axis] * (played.at(kAxes[axis]).back() - played.at(kAxes[axis]).front());
  for (std::size_t joint = 0; joint < angles.size(); ++joint)
    for (int n = 0; n <= kIntervals; ++n) {
      const double weight = n == 0 || n == kIntervals ? 1 : n % 2 == 1 ? 4 : 2;
      const double speed = arm.reach * std::cos(2.0 * n / kIntervals + static_cast<double>(joint)) * 2;
      taken += weight * speed * played.at("torque_" + std::to_string(joint + 1))[static_cast<std::size_t>(n)];
    }
  taken /= 3.0 * kIntervals;
  CHECK(std::abs(given) > 1e-3);
  CHECK(taken == Approx(given).epsilon(1e-9));
}

TEST_CASE("arms: conditioning is 1 where an arm is isotropic, and 0 where it is singular", "[nodes]") {
  // Two links, the first sqrt 2 times as long as the second, bent by 135 degrees: Salisbury & Craig, 1982.
  CHECK(
      value("two_link",
            {{"angle_1", 0.3}, {"angle_2", 0.75 * kTurn}, {"link_1", 0.1 * std::sqrt(2.0)}, {"link_2", 0.1}},
            "conditioning") == Approx(1).epsilon(1e-7));  // the root of the difference of two equal numbers
  CHECK(value("two_link", {{"angle_1", 0.3}, {"angle_2", 0.0}}, "conditioning") == Approx(0).margin(1e-12));
  CHECK(value("two_link", {{"angle_1", 0.3}, {"angle_2", kTurn}}, "conditioning") == Approx(0).margin(1e-12));
  // A gimbal whose pen is c away from the forearm: sqrt((1 - |cos c|) / (1 + |cos c|)), here below the
  // wrist's.
  const ArmInputs wrist{{"angle_1", 0.0}, {"angle_2", 1.0}, {"angle_3", -kTurn / 2},
                        {"angle_4", 0.4}, {"angle_5", 0.5}, {"angle_6", 0.0}};
  CHECK(value("six_axis", wrist, "conditioning") ==
        Approx(std::sqrt((1 - std::cos(0.5)) / (1 + std::cos(0.5)))).epsilon(1e-12));
}

TEST_CASE("arms: torques stay bounded where a closed chain is singular", "[nodes]") {
  // Five bars whose elbows come to lie 2 link_2 apart: their outer links are in one line. From an angle s
  // between these of 0.02 on, 0.47 mrad from there, the torques fall.
  const double widest = std::acos((0.075 - 0.0125) / 0.063);
  constexpr int kHalf = 2000;
  Samples left, right;
  for (int n = -kHalf; n <= kHalf; ++n) {
    left.push_back(kTurn - widest - 5e-7 * n);
    right.push_back(widest + 5e-7 * n);
  }
  const auto played =
      pose("five_bar", {{"angle_1", left}, {"angle_2", right}, {"force_y", 2.0}}, 2 * kHalf + 1);
  const auto& torque = played.at("torque_1");
  double most = 0, jump = 0;
  for (std::size_t n = 0; n < left.size(); ++n) {
    most = std::max(most, std::abs(torque[n]));
    if (n > 0) jump = std::max(jump, std::abs(torque[n] - torque[n - 1]));
  }
  // F u_x link_1 sin(angle + s / 2) / s, at s = 0.02.
  const double half = 0.5 * std::asin(0.02), angle = std::acos((0.075 * std::cos(half) - 0.0125) / 0.063);
  CHECK(most == Approx(2.0 * std::cos(half) * 0.063 * std::sin(angle + half) / 0.02).epsilon(1e-3));
  CHECK(jump < 0.1 * most);  // s grows as a root: the first step is the largest
  CHECK(played.at("conditioning")[kHalf] == Approx(0).margin(1e-3));
  CHECK(played.at("at_limit").front() == 1);  // the elbows are too far apart
  CHECK(torque.front() == Approx(0).margin(1e-6));
  CHECK(played.at("at_limit").back() == 0);
}

TEST_CASE("arms: limits of joints are reported, and a stop pushes back", "[nodes]") {
  const ArmSettings limits{{"limits", "[[-0.5, 0.5], [0.2, 2]]"}};
  const auto beyond =
      pose("two_link",
           {{"angle_1", Samples{0.4, 0.6, -0.6, 0}}, {"angle_2", Samples{1, 1, 1, 0.1}}, {"stop", 10.0}}, 4,
           limits);
  CHECK(beyond.at("at_limit") == Samples{0, 1, 1, 1});
  CHECK(beyond.at("torque_1")[0] == 0);
  CHECK(beyond.at("torque_1")[1] == Approx(-1).epsilon(1e-14));
  CHECK(beyond.at("torque_1")[2] == Approx(1).epsilon(1e-14));
  CHECK(beyond.at("torque_2")[3] == Approx(1).epsilon(1e-14));
  CHECK(refusal(test::node_type("two_link"), {{"angle_1", 0.0}, {"angle_2", 0.0}},
                {{"limits", "[[-1, 1]]"}}) == "BadArgument 'limits' 1 2 \"-90 deg\" \"90 deg\"");
  CHECK(refusal(test::node_type("two_link"), {{"angle_1", 0.0}, {"angle_2", 0.0}},
                {{"limits", "[[1, -1], [0, 1]]"}}) != "");
}

TEST_CASE("six_axis: it holds its weight, by the slopes of the potential energy", "[nodes]") {
  const double upper = 0.1, fore = 0.06, pen = 0.03, a = 0.133, b = 0.133;
  const ArmInputs masses{{"mass_1", upper}, {"mass_2", fore}, {"mass_3", pen}};
  const auto torque = [&](double shoulder, double elbow, const char* output) {
    auto inputs = masses;
    const double angles[] = {0.3, shoulder, elbow, 0.2, 0.9, 0.1};
    for (int i = 0; i < 6; ++i) inputs["angle_" + std::to_string(i + 1)] = angles[i];
    return value("six_axis", inputs, output);
  };
  // Stretched and level.
  CHECK(torque(0, 0, "torque_2") ==
        Approx(kGravity * (upper * a / 2 + fore * (a + b / 2) + pen * (a + b))).epsilon(1e-14));
  CHECK(torque(0, 0, "torque_3") == Approx(kGravity * (fore * b / 2 + pen * b)).epsilon(1e-14));
  CHECK(torque(kTurn / 2, 0, "torque_2") == Approx(0).margin(1e-15));
  const auto energy = [&](double shoulder, double elbow) {
    const double knee = a * std::sin(shoulder), wrist = knee + b * std::sin(shoulder + elbow);
    return kGravity * (upper * knee / 2 + fore * (knee + wrist) / 2 + pen * wrist);
  };
  const double s = 0.7, e = -1.1, h = 1e-5;
  CHECK(torque(s, e, "torque_2") == Approx((energy(s + h, e) - energy(s - h, e)) / (2 * h)).epsilon(1e-9));
  CHECK(torque(s, e, "torque_3") == Approx((energy(s, e + h) - energy(s, e - h)) / (2 * h)).epsilon(1e-9));
  for (const char* free : {"torque_1", "torque_4", "torque_5", "torque_6"}) CHECK(torque(s, e, free) == 0);
}
