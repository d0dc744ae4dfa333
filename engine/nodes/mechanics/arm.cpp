#include <algorithm>
#include <array>
#include <span>
#include <tuple>
#include <utility>

#include "engine/core/index.h"
#include "engine/nodes/declare.h"
#include "engine/nodes/mechanics/arm_conditioning_kernel.h"
#include "engine/nodes/mechanics/arm_setup.h"
#include "engine/nodes/mechanics/parallel_arm_kernel.h"
#include "engine/nodes/mechanics/serial_arm_kernel.h"

namespace tactus {
namespace {

/// Not `stateless`: its gains depend on the pose, and `tactus check` is to take the poses of the scene, not
/// those of any angle.
template <const ArmPorts& kArm, auto Pose>
class ArmNode final : public Node {
  using Inputs = std::array<double, index(kArm.inputs())>;

 public:
  explicit ArmNode(const tactus_arm_limits& limits) : limits_(limits) {}

  void process(const NodeBlock& block) noexcept override {
    Inputs in;
    for (int n = 0; n < block.frames; ++n) {
      for (int i = 0; i < kArm.inputs(); ++i) in[index(i)] = block.in[i][n];
      evaluate(in, [&](int output, auto value) {
        if (block.out[output] != nullptr) block.out[output][n] = value();
      });
    }
  }
  void reset() noexcept override {}

  /// Of angles and loads, by the central difference. Sizes that move, and what only reports, have no
  /// small-signal gain.
  std::optional<std::complex<double>> response(int input, int output, std::complex<double>,
                                               std::span<const double> at) const override {
    if (input >= kArm.first_size() || output == kArm.conditioning() || output == kArm.at_limit())
      return std::nullopt;
    constexpr double kStep = 1e-5;
    const auto moved = [&](double by) {
      Inputs in;
      std::copy_n(at.begin(), in.size(), in.begin());
      in[index(input)] += by;
      double found = 0;
      evaluate(in, [&](int other, auto value) {
        if (other == output) found = value();
      });
      return found;
    };
    return (moved(kStep) - moved(-kStep)) / (2 * kStep);
  }

 private:
  /// Gives each output as a function, which is called where it is read.
  template <class Give>
  void evaluate(const Inputs& in, Give give) const noexcept {
    tactus_arm_angles angles{};
    tactus_arm_load load{};
    tactus_arm_sizes sizes{};
    std::copy_n(in.begin(), kArm.joints, angles.of);
    std::copy_n(in.begin() + kArm.joints, kArm.axes, load.force);
    if constexpr (kArm.pen) std::copy_n(in.begin() + kArm.joints + kArm.axes, 3, load.moment);
    std::copy_n(in.begin() + kArm.first_size(), kArm.sizes(), sizes.of);
    const double stop = in.back();
    const tactus_arm_pose pose = Pose(angles, sizes);
    for (int axis = 0; axis < kArm.axes; ++axis) give(axis, [&] { return pose.tip[axis]; });
    for (int joint = 0; joint < kArm.joints; ++joint)
      give(kArm.axes + joint, [&] { return tactus_arm_torque(&pose, &load, angles, &limits_, stop, joint); });
    give(kArm.conditioning(), [&] {
      return kArm.pen ? tactus_six_axis_conditioning(&pose, sizes)
                      : tactus_arm_conditioning(&pose, kArm.axes);
    });
    give(kArm.at_limit(), [&] { return tactus_arm_at_limit(&pose, angles, &limits_); });
    for (int column = 0; kArm.pen && column < 3; ++column)
      for (int axis = 0; axis < 3; ++axis)
        give(kArm.facing(column, axis), [&] { return pose.facing[column][axis]; });
  }

  tactus_arm_limits limits_;
};

template <const ArmPorts& kArm, auto Pose>
Result<std::unique_ptr<Node>> make_arm(const NodeSetup& setup) {
  auto limits = arm_limits(setup, kArm.joints);
  if (!limits) return tl::unexpected(limits.error());
  return std::make_unique<ArmNode<kArm, Pose>>(*limits);
}

/// A tip goes no farther than the sum of the lengths.
auto range_of_arm(const ArmPorts& arm) {
  return [arm](int output, const NodeSetup& setup) -> Interval {
    if (output >= arm.conditioning()) return setup.type->outputs[index(output)].range;
    if (output >= arm.axes) return {};
    double reach = 0;
    for (int i = 0; i < arm.lengths; ++i) {
      const auto& port = setup.type->inputs[index(arm.first_size() + i)];
      reach += std::clamp(setup.input(port.name).range.high, port.low, port.high);
    }
    return {-reach, reach};
  };
}

const char* const kArmAxes[] = {"x", "y", "z"};

std::vector<InputPort> arm_inputs(const ArmPorts& arm, const std::vector<std::string>& angles,
                                  const std::vector<InputPort>& sizes) {
  std::vector<InputPort> inputs;
  for (int i = 0; i < arm.joints; ++i)
    inputs.push_back({"angle_" + std::to_string(i + 1), "rad", angles[index(i)]});
  for (int i = 0; i < arm.axes; ++i)
    inputs.push_back({std::string{"force_"} + kArmAxes[i], "N", "force on the device, at the tip", 0});
  for (int i = 0; arm.pen && i < 3; ++i)
    inputs.push_back({std::string{"moment_"} + kArmAxes[i], "N m", "moment on the pen", 0});
  inputs.insert(inputs.end(), sizes.begin(), sizes.end());
  inputs.push_back(
      {"stop", "N m/rad", "stiffness of virtual stops beyond `limits`; 0: these are only reported", 0, 0});
  return inputs;
}

std::vector<OutputPort> arm_outputs(const ArmPorts& arm) {
  std::vector<OutputPort> outputs;
  for (int i = 0; i < arm.axes; ++i) outputs.push_back({kArmAxes[i], "m", "position of the tip"});
  for (int i = 0; i < arm.joints; ++i)
    outputs.push_back({"torque_" + std::to_string(i + 1), "N m", "torque of the motor of this joint"});
  outputs.push_back(bounded(
      0, 1, {"conditioning", "", "smallest over largest singular value of the Jacobian; 0: singular"}));
  outputs.push_back(bounded(
      0, 1, {"at_limit", "", "1 while a joint is beyond its limits, or links do not reach each other"}));
  const std::pair<const char*, const char*> columns[] = {
      {"pen_", "direction of the pen: first column of its rotation matrix"},
      {"left_", "direction to the left of the pen: second column"},
      {"up_", "direction of the upper side of the pen: third column"}};
  for (const auto& [name, doc] : columns)
    for (int i = 0; arm.pen && i < 3; ++i)
      outputs.push_back(bounded(-1, 1, {std::string{name} + kArmAxes[i], "", doc}));
  return outputs;
}

std::vector<Setting> arm_settings() {
  return {{"limits",
           Setting::Kind::Points,
           "[[lowest, highest], ...], a pair for each joint; none: no limits",
           {"rad", "rad"}}};
}

InputPort arm_link(const char* name, const char* doc, double length) {
  return {name, "m", doc, length, TACTUS_ARM_SHORTEST, TACTUS_ARM_LONGEST};
}
/// A length that may be 0.
InputPort arm_offset(const char* name, const char* doc, double length) {
  return {name, "m", doc, length, 0, TACTUS_ARM_LONGEST};
}
InputPort held_mass(const char* name, const char* doc) {
  return {name, "kg", doc, 0, 0, TACTUS_ARM_HEAVIEST};
}

}  // namespace

Result<tactus_arm_limits> arm_limits(const NodeSetup& setup, int joints) {
  const auto& given = setup.setting("limits").points;
  tactus_arm_limits limits;
  std::fill_n(limits.low, TACTUS_ARM_JOINTS, -1e300);
  std::fill_n(limits.high, TACTUS_ARM_JOINTS, 1e300);
  if (given.empty()) return limits;
  if (std::ssize(given) != joints)
    return fail(Errc::BadArgument, {},
                "'limits' has " + std::to_string(given.size()) + " pairs, and the arm has " +
                    std::to_string(joints) + " joints",
                "write one [lowest, highest] for each joint, as in [\"-90 deg\", \"90 deg\"]");
  for (int joint = 0; joint < joints; ++joint) {
    std::tie(limits.low[joint], limits.high[joint]) = given[index(joint)];
    if (limits.low[joint] >= limits.high[joint])
      return fail(Errc::BadArgument, {},
                  "the limits of joint " + std::to_string(joint + 1) + " are not in ascending order",
                  "write the lower one first, as in [\"-90 deg\", \"90 deg\"]");
  }
  return limits;
}

NodeType two_link_type() {
  return {
      .name = "two_link",
      .summary = "Planar arm of two links: the position of its tip, and the torques of a force there.",
      .equation =
          "x = link_1 cos angle_1 + link_2 cos(angle_1 + angle_2), y the same with sin\n"
          "torque = J^T force + stop (limit - angle),  J = d(x, y) / d(angle_1, angle_2)\n"
          "conditioning is 0 where the arm is stretched or folded: its tip cannot be moved along it",
      .source = "Craig, Introduction to Robotics, 3rd ed. 2005, chapter 3 and section 5.9",
      .example =
          "arm = { type = \"two_link\", angle_1 = \"shoulder\", angle_2 = \"elbow\", limits = "
          "[[\"-90 deg\", \"90 deg\"], [\"5 deg\", \"150 deg\"]] }",
      .inputs =
          arm_inputs(kTwoLink, {"of the first link, from the x axis", "of the second link, from the first"},
                     {arm_link("link_1", "length of the first link", 0.15),
                      arm_link("link_2", "length of the second link", 0.15)}),
      .outputs = arm_outputs(kTwoLink),
      .settings = arm_settings(),
      .make = make_arm<kTwoLink, tactus_two_link>,
      .skips_unused_outputs = true,
      .range = range_of_arm(kTwoLink),
  };
}

NodeType five_bar_type() {
  return {
      .name = "five_bar",
      .summary =
          "Planar linkage of five bars (pantograph): the position of its tip, and the torques of a force "
          "there.",
      .equation =
          "elbow_1 = (-base / 2 + link_1 cos angle_1, link_1 sin angle_1)\n"
          "elbow_2 = (base / 2 + link_1 cos angle_2, link_1 sin angle_2);  |tip - elbow| = link_2\n"
          "torque = J^T force + stop (limit - angle),  J = A^-1 B\n"
          "A: rows of the unit vectors u = (tip - elbow) / link_2;  B = diag(u . d elbow / d angle)\n"
          "conditioning is 0 where the outer links, or the two links of a side, are in one line. Near the\n"
          "first, within 1.1 degrees, torques fall linearly to 0, where they would grow without limit",
      .source =
          "Campion, Wang & Hayward, The Pantograph Mk-II: a haptic instrument, IROS 2005, with its lengths "
          "as defaults",
      .example = "arm = { type = \"five_bar\", angle_1 = \"left\", angle_2 = \"right\", force_y = \"push\" }",
      .inputs = arm_inputs(
          kFiveBar,
          {"of the motor at -base / 2, from the x axis", "of the motor at base / 2, from the x axis"},
          {arm_offset("base", "distance of the motors", 0.025),
           arm_link("link_1", "from a motor to its elbow", 0.063),
           arm_link("link_2", "from an elbow to the tip", 0.075)}),
      .outputs = arm_outputs(kFiveBar),
      .settings = arm_settings(),
      .make = make_arm<kFiveBar, tactus_five_bar>,
      .skips_unused_outputs = true,
      .range = range_of_arm(kFiveBar),
  };
}

NodeType delta_type() {
  return {
      .name = "delta",
      .summary =
          "Parallel arm with three axes (delta): the position of its tip, and the torques of a force "
          "there.",
      .equation =
          "elbow = base + link_1 cos angle outwards, link_1 sin angle along z, 120 degrees apart\n"
          "|tip - elbow| = link_2 for all three\n"
          "torque = J^T force + stop (limit - angle),  J = A^-1 B as of five_bar\n"
          "conditioning is 0 where the three outer links are in one plane, or a side is stretched. Where\n"
          "their directions span a volume below 0.02, torques fall linearly to 0",
      .source =
          "Clavel, DELTA, a fast robot with parallel geometry, 18th Int. Symp. on Industrial Robots, 1988; "
          "default links: Novint Falcon, Martin & Hillier, Australasian Conf. on Robotics and Automation, "
          "2009; base: near that of the Falcon, chosen",
      .example = "arm = { type = \"delta\", angle_1 = \"first\", angle_2 = \"second\", angle_3 = \"third\" }",
      .inputs = arm_inputs(kDelta,
                           {"of the motor in direction x; 0: outwards, positive: towards z",
                            "of the motor at 120 degrees", "of the motor at 240 degrees"},
                           {arm_offset("base", "radius of the motors less that of the platform", 0.0226),
                            arm_link("link_1", "from a motor to its elbow", 0.06),
                            arm_link("link_2", "from an elbow to the platform", 0.1025)}),
      .outputs = arm_outputs(kDelta),
      .settings = arm_settings(),
      .make = make_arm<kDelta, tactus_delta>,
      .skips_unused_outputs = true,
      .range = range_of_arm(kDelta),
  };
}

NodeType six_axis_type() {
  return {
      .name = "six_axis",
      .summary =
          "Serial arm with six axes and a pen: the position and orientation of the pen, and the torques of "
          "a force and a moment there.",
      .equation =
          "R = Rz(angle_1) Ry(-angle_2 - angle_3) Rx(angle_4) Ry(-angle_5) Rx(angle_6): columns pen, left, "
          "up\n"
          "tip = upper arm + forearm + link_3 pen; with all angles 0 along x, and R = 1\n"
          "torque = J^T (force, moment) + weight + stop (limit - angle)\n"
          "weight: what holds mass_1 and mass_2 in the middles of the links and mass_3 at the wrist\n"
          "against 9.80665 m/s^2 along -z\n"
          "conditioning: the smaller of wrist and gimbal; 0 with the elbow stretched, the wrist above the\n"
          "base, or the pen in line with the forearm",
      .source =
          "Craig, Introduction to Robotics, 3rd ed. 2005, sections 5.9 and 6.8; the device: Massie & "
          "Salisbury, The PHANToM haptic interface, ASME DSC 55-1, 1994",
      .example =
          "arm = { type = \"six_axis\", angle_1 = \"base\", angle_2 = \"shoulder\", angle_3 = \"elbow\", "
          "angle_4 = \"roll\", angle_5 = \"pitch\", angle_6 = \"twist\", mass_2 = \"60 g\" }",
      .inputs = arm_inputs(
          kSixAxis,
          {"of the base, around z from the x axis", "of the shoulder; 0: the upper arm is level",
           "of the elbow; 0: the forearm is in line with the upper arm", "of the gimbal, around the forearm",
           "of the pen; 0: in line with the forearm", "around the pen"},
          {arm_link("link_1", "length of the upper arm", 0.133),
           arm_link("link_2", "length of the forearm", 0.133),
           arm_offset("link_3", "from the wrist to the tip of the pen", 0.04),
           held_mass("mass_1", "of the upper arm, to be held"),
           held_mass("mass_2", "of the forearm, to be held"),
           held_mass("mass_3", "of gimbal and pen, to be held")}),
      .outputs = arm_outputs(kSixAxis),
      .settings = arm_settings(),
      .make = make_arm<kSixAxis, tactus_six_axis>,
      .skips_unused_outputs = true,
      .range = range_of_arm(kSixAxis),
  };
}

}  // namespace tactus
