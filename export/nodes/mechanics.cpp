#include "engine/dsp/curves/curve.h"
#include "engine/dsp/resonators/modal_body.h"
#include "engine/nodes/mechanics/actuator_inverse_kernel.h"
#include "engine/nodes/mechanics/arm_setup.h"
#include "engine/nodes/mechanics/modal_body_setup.h"
#include "engine/nodes/mechanics/proxy_setup.h"
#include "engine/nodes/mechanics/terrain_kernel.h"
#include "engine/nodes/mechanics/virtual_force_kernel.h"
#include "export/nodes/curve_text.h"
#include "export/nodes/table.h"

namespace tactus {
namespace {

void write_terrain(NodeWriter& node) {
  enum Input { kPosition, kWeight, kHeight, kLength };
  const auto& profile = node.setting("profile");
  std::string shape;
  if (profile == "points") {
    const auto curve = CubicCurve::spline(node.setup().setting("points").points);
    shape =
        "tactus_cubic_at(&" + write_curve_table(node, curve.view(), true) + ", " + node.in(kPosition) + ")";
  } else {
    shape = std::string{profile == "sine" ? "tactus_terrain_sine(" : "tactus_terrain_detent("} +
            node.in(kPosition) + ", tactus_max(0.0, " + node.in(kHeight) +
            "), tactus_max(TACTUS_TERRAIN_SHORTEST, " + node.in(kLength) + "))";
  }
  const auto point = node.local("tactus_cubic_point", "shape", shape);
  node.give(0, "tactus_terrain_force(" + node.in(kWeight) + ", " + point + ".slope)");
  node.give(1, point + ".value");
}

void write_actuator_inverse(NodeWriter& node) {
  const auto state = node.state<tactus_actuator_inverse>("tactus_actuator_inverse");
  std::string values = node.in(1);
  for (int i = 2; i <= 6; ++i) values += ", " + node.in(i);
  const auto actuator = node.local("tactus_actuator", "actuator", "{" + values + "}");
  node.call(0, "tactus_actuator_inverse_step(&" + state + ", " + node.in(0) + ", &" + actuator + ", " +
                   node.in(7) + ", " + node.in(8) + ", " + node.rate() + ")");
  node.give(1, state + ".smooth[2]");
  node.give(2, state + ".position");
}

void write_modal_body(NodeWriter& node) {
  const auto setup = *body_setup(node.setup());
  const ModalBody body{setup.modes, setup.impedance, node.setup().sample_rate};
  const auto groups = body.groups();
  const int count = static_cast<int>(groups.size());
  const auto state = node.state<tactus_modal_body>("tactus_modal_body");
  const auto modes =
      count > 0 ? node.state<tactus_body_modes>("tactus_body_modes", "modes", count) : std::string{"0"};
  const auto copy = [&](const char* name, auto member) {
    std::vector<double> numbers;
    for (const auto& group : groups)
      for (const double number : group.*member) numbers.push_back(number);
    return modes + "[k / 8]." + name + "[k % 8] = " + node.table(name, numbers) + "[k];";
  };
  if (count > 0)
    node.start("for (int k = 0; k < " + std::to_string(8 * count) + "; ++k) {\n    " +
               copy("give", &tactus_body_modes::give) + "\n    " +
               copy("mass_turn", &tactus_body_modes::mass_turn) + "\n    " +
               copy("spring_turn", &tactus_body_modes::spring_turn) + "\n    " +
               copy("per_spring", &tactus_body_modes::per_spring) + "\n  }");
  const auto& scalars = body.scalars();
  const auto set = [&](const char* name, double value) {
    node.start(state + "." + name + " = " + NodeWriter::number(value) + ";");
  };
  set("impedance", scalars.impedance);
  set("half_frame", scalars.half_frame);
  set("by_wave", scalars.by_wave);
  set("by_state", scalars.by_state);
  const auto answer = node.local("tactus_body_answer", "answer",
                                 "tactus_modal_body_step(&" + state + ", " + modes + ", " +
                                     std::to_string(count) + ", " + node.in(0) + ")");
  // What joins two ports pushes both apart; here up is up as for the mass on the other side.
  node.give(0, answer + ".wave");
  node.give(1, "-" + answer + ".velocity");
  node.give(2, "-" + answer + ".position");
  node.give(3, "-" + answer + ".force");
}

/// `count` inputs from `first` on, as a list in braces.
std::string braced(const NodeWriter& node, int first, int count) {
  std::string list;
  for (int i = first; i < first + count; ++i) list += (list.empty() ? "" : ", ") + node.in(i);
  return "{" + list + "}";
}

/// The limits of its joints, as a table.
std::string arm_limits_of(NodeWriter& node, int joints) {
  const auto bounds = *arm_limits(node.setup(), joints);
  std::string low, high;
  for (int joint = 0; joint < TACTUS_ARM_JOINTS; ++joint) {
    low += (joint > 0 ? ", " : "") + NodeWriter::number(bounds.low[joint]);
    high += (joint > 0 ? ", " : "") + NodeWriter::number(bounds.high[joint]);
  }
  return node.table("tactus_arm_limits", "limits", "{{" + low + "}, {" + high + "}}",
                    sizeof(tactus_arm_limits));
}

/// The kernel of the entry is the function of the pose.
template <const ArmPorts& kArm>
void write_arm(NodeWriter& node) {
  const auto angles = node.local("tactus_arm_angles", "angles", "{" + braced(node, 0, kArm.joints) + "}");
  const auto sizes =
      node.local("tactus_arm_sizes", "sizes", "{" + braced(node, kArm.first_size(), kArm.sizes()) + "}");
  const auto pose = node.local("tactus_arm_pose", "pose", node.kernel() + "(" + angles + ", " + sizes + ")");
  const auto at = [](const char* member, int i) {
    return std::string{"."} + member + "[" + std::to_string(i) + "]";
  };
  for (int axis = 0; axis < kArm.axes; ++axis) node.give(axis, pose + at("tip", axis));
  bool torques = false;
  for (int joint = 0; joint < kArm.joints; ++joint) torques = torques || node.reads(kArm.axes + joint);
  const auto limits =
      torques || node.reads(kArm.at_limit()) ? arm_limits_of(node, kArm.joints) : std::string{};
  if (torques) {
    const auto moment = kArm.pen ? braced(node, kArm.joints + kArm.axes, 3) : std::string{"{0}"};
    const auto load = node.local("tactus_arm_load", "load",
                                 "{" + braced(node, kArm.joints, kArm.axes) + ", " + moment + "}");
    for (int joint = 0; joint < kArm.joints; ++joint)
      node.give(kArm.axes + joint, "tactus_arm_torque(&" + pose + ", &" + load + ", " + angles + ", &" +
                                       limits + ", " + node.in(kArm.stop()) + ", " + std::to_string(joint) +
                                       ")");
  } else {  // what is computed for inputs that nothing needs is no unused variable
    for (int i = kArm.joints; i <= kArm.stop(); ++i)
      if (i < kArm.first_size() || i == kArm.stop()) node.step("(void)(" + node.in(i) + ");");
  }
  node.give(kArm.conditioning(),
            kArm.pen ? "tactus_six_axis_conditioning(&" + pose + ", " + sizes + ")"
                     : "tactus_arm_conditioning(&" + pose + ", " + std::to_string(kArm.axes) + ")");
  node.give(kArm.at_limit(), "tactus_arm_at_limit(&" + pose + ", " + angles + ", &" + limits + ")");
  for (int column = 0; kArm.pen && column < 3; ++column)
    for (int axis = 0; axis < 3; ++axis)
      node.give(kArm.facing(column, axis), pose + at("facing", column) + "[" + std::to_string(axis) + "]");
}

void write_proxy(NodeWriter& node) {
  const auto setup = *proxy_setup(node.setup());
  constexpr const char* kShapes[] = {"TACTUS_SOLID_PLANE", "TACTUS_SOLID_SPHERE", "TACTUS_SOLID_BOX",
                                     "TACTUS_SOLID_HEIGHTS"};
  const auto state = node.state<tactus_proxy>("tactus_proxy");
  const auto heights = node.table("heights", setup.heights);
  const auto count = std::to_string(kProxyInputs - kProxySolid);
  const auto numbers = node.local("struct { tactus_real of[" + count + "]; }", "numbers",
                                  "{" + braced(node, kProxySolid, kProxyInputs - kProxySolid) + "}");
  const auto solid =
      node.local("tactus_solid", "solid",
                 std::string{"tactus_solid_of("} + kShapes[setup.shape] + ", " + numbers + ".of, " + heights +
                     ", " + std::to_string(setup.rows) + ", " + std::to_string(setup.columns) + ")");
  const auto place =
      node.local("struct { tactus_real of[3]; }", "place", "{" + braced(node, kProxyPlace, 3) + "}");
  std::string device;
  for (int i = 0; i < 3; ++i)
    device += (i > 0 ? ", " : "") + node.operand(i) + " - " + place + ".of[" + std::to_string(i) + "]";
  const auto at = node.local("struct { tactus_real of[3]; }", "device", "{{" + device + "}}");
  const auto step = "tactus_proxy_step(&" + state + ", &" + solid + ", " + at + ".of, " + node.in(3) + ", " +
                    node.in(4) + ")";
  const bool is_felt = node.reads(0) || node.reads(1) || node.reads(2) || node.reads(6);
  const auto felt = is_felt ? node.local("tactus_proxy_force", "felt", step) : "";
  if (!is_felt) node.step(step + ";");
  for (int i = 0; i < 3; ++i) {
    const auto axis = "[" + std::to_string(i) + "]";
    node.give(i, felt + ".force" + axis);
    node.give(3 + i, state + ".at" + axis + " + " + place + ".of" + axis);
  }
  node.give(6, felt + ".depth");
  node.give(7, state + ".side > 0");
  node.give(8, state + ".slips");
}

constexpr NodeExport kMechanics[] = {
    {"spring", write_value, "tactus_spring_force"},
    {"damper", write_value, "tactus_damper_force"},
    {"wall", write_value, "tactus_wall_force"},
    {"terrain", write_terrain},
    {"actuator_inverse", write_actuator_inverse},
    {"modal_body", write_modal_body},
    {"two_link", write_arm<kTwoLink>, "tactus_two_link"},
    {"five_bar", write_arm<kFiveBar>, "tactus_five_bar"},
    {"delta", write_arm<kDelta>, "tactus_delta"},
    {"six_axis", write_arm<kSixAxis>, "tactus_six_axis"},
    {"proxy", write_proxy},
};

}  // namespace

std::span<const NodeExport> exported_mechanics() { return kMechanics; }

}  // namespace tactus
