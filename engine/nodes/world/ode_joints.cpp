#include "engine/nodes/world/ode_joints.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "engine/core/index.h"

namespace tactus {
namespace {

constexpr double kLeastAxis2 = 1e-12;

/// What the library does with each kind of joint; nullptr: this kind has nothing of it.
struct JointCalls {
  dJointID (*create)(dWorldID, dJointGroupID);
  void (*set_anchor)(dJointID, dReal, dReal, dReal);
  void (*set_axis)(dJointID, dReal, dReal, dReal);
  void (*set_second_axis)(dJointID, dReal, dReal, dReal);
  void (*set_parameter)(dJointID, int, dReal);
  void (*drive)(dJointID, dReal, dReal);
  dReal (*position)(dJointID);
  dReal (*rate)(dJointID);
};

void set_first_axis_of_hinge2(dJointID id, dReal x, dReal y, dReal z) {
  const dVector3 axis = {x, y, z};
  dJointSetHinge2Axes(id, axis, nullptr);
}
void set_second_axis_of_hinge2(dJointID id, dReal x, dReal y, dReal z) {
  const dVector3 axis = {x, y, z};
  dJointSetHinge2Axes(id, nullptr, axis);
}
void drive_hinge(dJointID id, dReal torque, dReal) { dJointAddHingeTorque(id, torque); }
void drive_slider(dJointID id, dReal force, dReal) { dJointAddSliderForce(id, force); }
void drive_piston(dJointID id, dReal force, dReal) { dJointAddPistonForce(id, force); }

/// By WorldJoint.
constexpr JointCalls kCalls[] = {
    {dJointCreateHinge, dJointSetHingeAnchor, dJointSetHingeAxis, nullptr, dJointSetHingeParam, drive_hinge,
     dJointGetHingeAngle, dJointGetHingeAngleRate},
    {dJointCreateSlider, nullptr, dJointSetSliderAxis, nullptr, dJointSetSliderParam, drive_slider,
     dJointGetSliderPosition, dJointGetSliderPositionRate},
    {dJointCreateBall, dJointSetBallAnchor, nullptr, nullptr, nullptr, nullptr, nullptr, nullptr},
    {dJointCreateFixed, nullptr, nullptr, nullptr, nullptr, nullptr, nullptr, nullptr},
    {dJointCreateUniversal, dJointSetUniversalAnchor, dJointSetUniversalAxis1, dJointSetUniversalAxis2,
     dJointSetUniversalParam, dJointAddUniversalTorques, dJointGetUniversalAngle1,
     dJointGetUniversalAngle1Rate},
    {dJointCreateHinge2, dJointSetHinge2Anchor, set_first_axis_of_hinge2, set_second_axis_of_hinge2,
     dJointSetHinge2Param, dJointAddHinge2Torques, dJointGetHinge2Angle1, dJointGetHinge2Angle1Rate},
    {dJointCreatePiston, dJointSetPistonAnchor, dJointSetPistonAxis, nullptr, dJointSetPistonParam,
     drive_piston, dJointGetPistonPosition, dJointGetPistonPositionRate},
};
static_assert(std::size(kCalls) == kJointKinds);

const JointCalls& calls_of(WorldJoint kind) { return kCalls[static_cast<int>(kind)]; }

void set_stops(const JointCalls& calls, dJointID id, double low, double high) {
  if (calls.set_parameter == nullptr) return;
  for (const int group : {0, int{dParamGroup2}}) {
    if (group != 0 && calls.set_second_axis == nullptr) break;
    calls.set_parameter(id, group + dParamLoStop, std::isfinite(low) ? low : -dInfinity);
    calls.set_parameter(id, group + dParamHiStop, std::isfinite(high) ? high : dInfinity);
  }
}

/// The library ends the program where an axis has no direction.
bool has_directions(const JointModel& model) {
  const auto& a = model.axis;
  const auto& b = model.second_axis;
  const Vector3 across = {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
  const auto& calls = calls_of(model.kind);
  const auto& needed = calls.set_second_axis != nullptr ? across : a;
  return calls.set_axis == nullptr || dot(needed.data(), needed.data()) > kLeastAxis2;
}

}  // namespace

OdeJoints::OdeJoints(dWorldID world, const RigidModel& model, std::span<const OdeBody> bodies)
    : step_s_(model.step_s), bodies_(bodies) {
  for (const auto& of_file : model.joints) {
    auto& joint = joints_.emplace_back();
    joint.model = of_file;
    joint.id = calls_of(of_file.kind).create(world, nullptr);
    attach(joint);
  }
  for (int link = 0; link < model.links; ++link) {
    auto& joint = joints_.emplace_back();
    joint.model.on = -1;
    for (const auto& calls : kCalls) joint.kinds.push_back(calls.create(world, nullptr));
  }
}

void OdeJoints::attach(Joint& joint) noexcept {
  const auto& model = joint.model;
  const auto& calls = calls_of(model.kind);
  dJointAttach(joint.id, body(model.on), body(model.against));
  const auto set = [&](auto call, const Vector3& v) {
    if (call != nullptr) call(joint.id, v[0], v[1], v[2]);
  };
  set(calls.set_anchor, model.anchor);
  set(calls.set_axis, model.axis);
  set(calls.set_second_axis, model.second_axis);
  if (model.kind == WorldJoint::Fixed) dJointSetFixed(joint.id);
  set_stops(calls, joint.id, model.low, model.high);
}

void OdeJoints::link(int number, const JointModel& as) noexcept {
  auto& joint = joints_[index(number)];
  if (joint.id != nullptr) dJointAttach(joint.id, nullptr, nullptr);
  joint.id = nullptr;
  joint.model = as;
  joint.stiffness = joint.damping = 0;
  const auto on = body(as.on), against = body(as.against);
  if (on == nullptr || on == against || !has_directions(as)) return;
  // The second axis of this one belongs to the second body.
  if (as.kind == WorldJoint::Hinge2 && against == nullptr) return;
  joint.on = pose_of(on);
  if (against != nullptr) joint.against = pose_of(against);
  joint.id = joint.kinds[static_cast<std::size_t>(as.kind)];
  attach(joint);
  follow_presence();
}

void OdeJoints::remove_links() noexcept {
  for (std::size_t j = 0; j < joints_.size(); ++j)
    if (!joints_[j].kinds.empty() && joints_[j].id != nullptr) link(static_cast<int>(j), {.on = -1});
}

void OdeJoints::copy_links(const OdeJoints& other) noexcept {
  for (std::size_t j = 0; j < std::min(joints_.size(), other.joints_.size()); ++j) {
    const auto& from = other.joints_[j];
    if (joints_[j].kinds.empty() || from.kinds.empty()) continue;
    if (from.id == nullptr) {
      link(static_cast<int>(j), {.on = -1});
      continue;
    }
    set_pose(body(from.model.on), from.on);
    if (const auto against = body(from.model.against)) set_pose(against, from.against);
    link(static_cast<int>(j), from.model);
    set_spring(static_cast<int>(j), from.stiffness, from.damping);
  }
}

/// A stop at 0 from both sides, softened to a spring and a damper: erp = hk / (hk + c), cfm = 1 / (hk + c).
void OdeJoints::set_spring(int number, double stiffness, double damping) noexcept {
  auto& joint = joints_[index(number)];
  if (joint.id == nullptr || (joint.stiffness == stiffness && joint.damping == damping)) return;
  joint.stiffness = stiffness;
  joint.damping = damping;
  const auto& calls = calls_of(joint.model.kind);
  if (calls.set_parameter == nullptr) return;
  const double give = step_s_ * stiffness + damping;
  if (!(give > 0)) return set_stops(calls, joint.id, joint.model.low, joint.model.high);
  set_stops(calls, joint.id, 0, 0);
  for (const int group : {0, int{dParamGroup2}}) {
    if (group != 0 && calls.set_second_axis == nullptr) break;
    calls.set_parameter(joint.id, group + dParamStopERP, step_s_ * stiffness / give);
    calls.set_parameter(joint.id, group + dParamStopCFM, 1 / give);
  }
}

void OdeJoints::drive(int number, double effort, double second) noexcept {
  const auto& joint = joints_[index(number)];
  if ((effort == 0 && second == 0) || joint.id == nullptr || !dJointIsEnabled(joint.id)) return;
  if (const auto call = calls_of(joint.model.kind).drive) call(joint.id, effort, second);
}

void OdeJoints::follow_presence() noexcept {
  for (const auto& joint : joints_) {
    if (joint.id == nullptr) continue;
    const auto present = [&](int number) { return number < 0 || bodies_[index(number)].present; };
    present(joint.model.on) && present(joint.model.against) ? dJointEnable(joint.id)
                                                            : dJointDisable(joint.id);
  }
}

double OdeJoints::position(int number) const noexcept {
  const auto& joint = joints_[index(number)];
  const auto call = calls_of(joint.model.kind).position;
  return joint.id != nullptr && call != nullptr ? call(joint.id) : 0.0;
}

double OdeJoints::rate(int number) const noexcept {
  const auto& joint = joints_[index(number)];
  const auto call = calls_of(joint.model.kind).rate;
  return joint.id != nullptr && call != nullptr ? call(joint.id) : 0.0;
}

bool OdeJoints::linked(std::size_t one, std::size_t other) const noexcept {
  return std::any_of(joints_.begin(), joints_.end(), [&](const Joint& joint) {
    if (joint.id == nullptr) return false;
    const auto& model = joint.model;
    const auto a = index(model.on), b = index(model.against < 0 ? model.on : model.against);
    return (a == one && b == other) || (a == other && b == one);
  });
}

}  // namespace tactus
