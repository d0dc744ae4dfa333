#pragma once

// Thread: [realtime], except where a function says otherwise
#include <array>
#include <cstddef>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "engine/core/error.h"
#include "engine/nodes/world/world_elements.h"

namespace tactus {

using Vector3 = std::array<double, 3>;

/// How much of what a body is made of, and how it moves when it is put at a place.
struct BodyState {
  Vector3 position{}, velocity{};
  std::array<double, 3> size{};  ///< radius; width, depth, height; radius, length
  double mass = 1;
};

struct BodyModel {
  WorldShape shape = WorldShape::Sphere;
  bool moves = true, collides = true, present = true;
  double friction = 0.5, restitution = 0;
  Vector3 turn{};           ///< axis x angle
  Vector3 normal{0, 0, 1};  ///< of a plane
  double offset = 0;        ///< of a plane
  BodyState initial = {};
};

struct JointModel {
  WorldJoint kind = WorldJoint::Hinge;
  int on = 0, against = -1;  ///< bodies; -1: the world; of a link that is not made `on` is -1
  Vector3 anchor{}, axis{1, 0, 0};
  Vector3 second_axis{0, 1, 0};  ///< of kinds with two
  double low = -std::numeric_limits<double>::infinity(), high = std::numeric_limits<double>::infinity();
};

struct RigidModel {
  std::vector<BodyModel> bodies;
  std::vector<JointModel> joints;
  int links = 0;  ///< joints that are made while it runs, behind those of the file
  double step_s = 0.001;
  bool direct = true;
  int iterations = 20;
  int most_contacts = 16;
  double erp = 0.2, cfm = 0;  ///< of contacts
  double bounce_speed = 0.01;
  double correction_speed = std::numeric_limits<double>::infinity();

  /// [any] Bytes that the bodies, the contacts and the solver need at most.
  std::size_t bytes() const;
};

/// Two bodies that touch in the last step.
struct RigidContact {
  int one = 0, other = 0;  ///< bodies, the lower one first
  bool began = false;      ///< they did not touch in the step before
  double impulse = 0;      ///< of the normal forces, N s
  double speed = 0;        ///< of approach before the step, m/s
  double depth = 0;        ///< m
  Vector3 place{};         ///< of the deepest point
};

/// Rigid bodies with joints and contacts, stepped by the Open Dynamics Engine 0.16: semi-implicit Euler, in
/// which contacts and joints are constraints on velocities (Stewart & Trinkle, Int. J. Numer. Methods Eng.
/// 39, 1996; Anitescu & Potra, Nonlinear Dynamics 14, 1997). All memory is taken when it is made; a step
/// that needs more is not computed and counted. Steps of the iterative solver take turns with those of other
/// worlds, since its random numbers are shared by the process; the direct solver needs none.
class RigidBodies {
 public:
  /// [control] Errors: BadArgument where the library lacks memory or double precision.
  static Result<std::unique_ptr<RigidBodies>> make(RigidModel model);
  virtual ~RigidBodies() = default;

  virtual void set_gravity(const Vector3& acceleration) noexcept = 0;
  /// Size and mass, where they differ.
  virtual void resize(int body, const BodyState& to) noexcept = 0;
  /// Puts a body at a place, turned as at first.
  virtual void place(int body, const Vector3& at) noexcept = 0;
  /// Gives it a velocity and stops its rotation.
  virtual void launch(int body, const Vector3& velocity) noexcept = 0;
  virtual void set_present(int body, bool present) noexcept = 0;
  virtual bool present(int body) const noexcept = 0;
  /// For the next step.
  virtual void push(int body, const Vector3& force) noexcept = 0;
  /// A torque or force about or along the first axis, and the second one.
  virtual void drive(int joint, double effort, double second) noexcept = 0;
  /// Makes, changes or removes a link between bodies as they are now.
  virtual void link(int joint, const JointModel& as) noexcept = 0;
  /// Pulls a link to where it was made; 0 and 0: nothing does.
  virtual void set_spring(int joint, double stiffness, double damping) noexcept = 0;
  virtual void step() noexcept = 0;
  /// After a step: no body is farther away than 1e9 m, faster than 1e9 m/s or turns faster than 1e9 rad/s,
  /// from where the next step could overflow; a world that is not must be reset. Always false where an
  /// assertion of the library has stopped the world, which then stays at rest until it is made anew.
  virtual bool within_range() const noexcept = 0;
  virtual void reset() noexcept = 0;
  /// Continues as `other`, made from the same model but for numbers.
  virtual void copy(const RigidBodies& other) noexcept = 0;

  virtual Vector3 position(int body) const noexcept = 0;
  virtual Vector3 velocity(int body) const noexcept = 0;
  virtual Vector3 turning(int body) const noexcept = 0;             ///< rad/s
  virtual std::array<double, 4> turn(int body) const noexcept = 0;  ///< unit quaternion: w, x, y, z
  virtual const BodyState& state(int body) const noexcept = 0;      ///< its size and mass
  virtual double joint_position(int joint) const noexcept = 0;
  virtual double joint_rate(int joint) const noexcept = 0;
  virtual std::span<const RigidContact> contacts() const noexcept = 0;
  virtual double energy() const noexcept = 0;
  /// Steps that were not computed, or without some contacts.
  virtual double refused() const noexcept = 0;
  /// [any] Most bytes in use so far.
  virtual std::size_t bytes_used() const noexcept = 0;
};

}  // namespace tactus
