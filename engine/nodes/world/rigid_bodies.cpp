#include "engine/nodes/world/rigid_bodies.h"

#include <ode/ode.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <cstring>
#include <utility>

#include "engine/core/index.h"
#include "engine/nodes/world/ode_memory.h"

namespace tactus {
namespace {

constexpr int kContactsOfPair = 4;
/// Two bodies may have more points of contact than their rank: without a little compliance the matrix is
/// singular. It changes an impulse by 1e-10 m / step, where m is the mass.
constexpr double kLeastCompliance = 1e-10;
constexpr double kLeastSlip_m_per_s = 1e-6;
constexpr double kLeastSize_m = 1e-6, kLeastMass_kg = 1e-9;

double dot(const double* a, const double* b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Vector3 vector_of(const dReal* v) { return {v[0], v[1], v[2]}; }

/// Of the generator that all iterative solvers of the process share.
class RandomTurn {
 public:
  explicit RandomTurn(bool needed) noexcept : needed_(needed) {
    while (needed_ && taken_.test_and_set(std::memory_order_acquire)) {
    }
    if (needed_) dRandSetSeed(0);
  }
  ~RandomTurn() {
    if (needed_) taken_.clear(std::memory_order_release);
  }
  RandomTurn(const RandomTurn&) = delete;
  RandomTurn& operator=(const RandomTurn&) = delete;

 private:
  static inline std::atomic_flag taken_;
  bool needed_;
};

dMass mass_of(WorldShape shape, const BodyState& state) {
  dMass mass;
  const auto& size = state.size;
  if (shape == WorldShape::Sphere)
    dMassSetSphereTotal(&mass, state.mass, size[0]);
  else if (shape == WorldShape::Box)
    dMassSetBoxTotal(&mass, state.mass, size[0], size[1], size[2]);
  else
    dMassSetCapsuleTotal(&mass, state.mass, 3, size[0], size[1]);
  return mass;
}

BodyState within_limits(BodyState state) {
  for (auto& size : state.size) size = std::max(size, kLeastSize_m);
  state.mass = std::max(state.mass, kLeastMass_kg);
  return state;
}

class OdeBodies final : public RigidBodies {
 public:
  // Bodies, shapes and joints are not in the arena: the library keeps the place of a shape that is destroyed
  // for the next one of any world.
  explicit OdeBodies(RigidModel model) : model_(std::move(model)), arena_(model_.bytes()) {
    world_ = dWorldCreate();
    // The one that all worlds share otherwise is not safe to use from two threads.
    threading_ = dThreadingAllocateSelfThreadedImplementation();
    dWorldSetStepThreadingImplementation(world_, dThreadingImplementationGetFunctions(threading_),
                                         threading_);
    group_ = dJointGroupCreate(0);
    dWorldSetQuickStepNumIterations(world_, model_.iterations);
    if (std::isfinite(model_.correction_speed))
      dWorldSetContactMaxCorrectingVel(world_, model_.correction_speed);
    for (const auto& body : model_.bodies) add_body(body);
    for (const auto& joint : model_.joints) add_joint(joint);
    boxes_.resize(bodies_.size() * 6);
    touched_.resize(bodies_.size() * bodies_.size());
    touching_ = touched_;
    const auto most = index(model_.most_contacts);
    contacts_.reserve(most);
    points_.reserve(most);
    feedback_.resize(most);
    reserve();
    reset();
  }

  ~OdeBodies() override {
    const OdeArena::Use use{arena_};
    dJointGroupDestroy(group_);
    for (const auto& body : bodies_) dGeomDestroy(body.geom);
    dWorldDestroy(world_);
    dThreadingFreeImplementation(threading_);
  }

  void set_gravity(const Vector3& g) noexcept override {
    gravity_ = g;
    dWorldSetGravity(world_, g[0], g[1], g[2]);
  }

  void resize(int number, const BodyState& wanted) noexcept override {
    auto& body = bodies_[index(number)];
    const auto to = within_limits(wanted);
    if (model_.bodies[index(number)].shape == WorldShape::Plane) return;
    if (to.size == body.state.size && to.mass == body.state.mass) return;
    apply_size(index(number), to);
  }

  void place(int number, const Vector3& p) noexcept override {
    const auto& model = model_.bodies[index(number)];
    auto& body = bodies_[index(number)];
    if (model.shape == WorldShape::Plane) return;
    dQuaternion turned;
    const double angle = std::sqrt(dot(model.turn.data(), model.turn.data()));
    dQFromAxisAndAngle(turned, model.turn[0], model.turn[1], angle > 0 ? model.turn[2] : 1.0, angle);
    if (body.body == nullptr) {
      dGeomSetPosition(body.geom, p[0], p[1], p[2]);
      dGeomSetQuaternion(body.geom, turned);
      return;
    }
    dBodySetPosition(body.body, p[0], p[1], p[2]);
    dBodySetQuaternion(body.body, turned);
  }

  void launch(int number, const Vector3& v) noexcept override {
    const auto body = bodies_[index(number)].body;
    if (body == nullptr) return;
    dBodySetLinearVel(body, v[0], v[1], v[2]);
    dBodySetAngularVel(body, 0, 0, 0);
  }

  void set_present(int number, bool present) noexcept override {
    auto& body = bodies_[index(number)];
    if (present == body.present) return;
    body.present = present;
    present ? dGeomEnable(body.geom) : dGeomDisable(body.geom);
    if (body.body != nullptr) present ? dBodyEnable(body.body) : dBodyDisable(body.body);
    for (std::size_t j = 0; j < joints_.size(); ++j) {
      const auto& joint = model_.joints[j];
      const bool whole =
          bodies_[index(joint.on)].present && (joint.against < 0 || bodies_[index(joint.against)].present);
      whole ? dJointEnable(joints_[j]) : dJointDisable(joints_[j]);
    }
  }
  bool present(int body) const noexcept override { return bodies_[index(body)].present; }

  void push(int body, const Vector3& f) noexcept override {
    const auto& one = bodies_[index(body)];
    if (one.body != nullptr && one.present) dBodyAddForce(one.body, f[0], f[1], f[2]);
  }

  void drive(int joint, double effort) noexcept override {
    if (effort == 0 || !dJointIsEnabled(joints_[index(joint)])) return;
    const auto kind = model_.joints[index(joint)].kind;
    if (kind == WorldJoint::Hinge) dJointAddHingeTorque(joints_[index(joint)], effort);
    if (kind == WorldJoint::Slider) dJointAddSliderForce(joints_[index(joint)], effort);
  }

  void step() noexcept override {
    const OdeArena::Use use{arena_};
    const bool all = find_contacts();
    bool done = false;
    {
      const RandomTurn turn{!model_.direct};
      done =
          (model_.direct ? dWorldStep(world_, model_.step_s) : dWorldQuickStep(world_, model_.step_s)) != 0;
    }
    if (done) read_impulses();
    if (!all || !done) ++refused_;
    dJointGroupEmpty(group_);
    touched_.swap(touching_);
  }

  void reset() noexcept override {
    set_gravity({});
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      const auto& initial = model_.bodies[i].initial;
      resize(static_cast<int>(i), initial);
      place(static_cast<int>(i), initial.position);
      launch(static_cast<int>(i), initial.velocity);
      set_present(static_cast<int>(i), model_.bodies[i].present);
    }
    std::fill(touched_.begin(), touched_.end(), char{0});
    contacts_.clear();
    refused_ = 0;
  }

  void copy(const RigidBodies& from) noexcept override {
    const auto& other = static_cast<const OdeBodies&>(from);
    if (other.bodies_.size() != bodies_.size()) return;
    set_gravity(other.gravity_);
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      if (model_.bodies[i].shape == WorldShape::Plane) continue;
      copy_body(bodies_[i], other.bodies_[i]);
      resize(static_cast<int>(i), other.bodies_[i].state);
      set_present(static_cast<int>(i), other.bodies_[i].present);
    }
    touched_ = other.touched_;  // of the same size: nothing is allocated
    contacts_.assign(other.contacts_.begin(),
                     other.contacts_.begin() + std::min(std::ssize(other.contacts_),
                                                        static_cast<std::ptrdiff_t>(contacts_.capacity())));
    refused_ = other.refused_;
  }

  Vector3 position(int body) const noexcept override {
    const auto& one = bodies_[index(body)];
    if (one.body != nullptr) return vector_of(dBodyGetPosition(one.body));
    return model_.bodies[index(body)].shape == WorldShape::Plane ? Vector3{}
                                                                 : vector_of(dGeomGetPosition(one.geom));
  }
  Vector3 velocity(int body) const noexcept override {
    const auto* one = bodies_[index(body)].body;
    return one != nullptr ? vector_of(dBodyGetLinearVel(bodies_[index(body)].body)) : Vector3{};
  }
  Vector3 turning(int body) const noexcept override {
    const auto* one = bodies_[index(body)].body;
    return one != nullptr ? vector_of(dBodyGetAngularVel(bodies_[index(body)].body)) : Vector3{};
  }
  double mass(int body) const noexcept override { return bodies_[index(body)].state.mass; }

  double joint_position(int joint) const noexcept override {
    const auto id = joints_[index(joint)];
    const auto kind = model_.joints[index(joint)].kind;
    return kind == WorldJoint::Hinge    ? dJointGetHingeAngle(id)
           : kind == WorldJoint::Slider ? dJointGetSliderPosition(id)
                                        : 0.0;
  }
  double joint_rate(int joint) const noexcept override {
    const auto id = joints_[index(joint)];
    const auto kind = model_.joints[index(joint)].kind;
    return kind == WorldJoint::Hinge    ? dJointGetHingeAngleRate(id)
           : kind == WorldJoint::Slider ? dJointGetSliderPositionRate(id)
                                        : 0.0;
  }

  std::span<const RigidContact> contacts() const noexcept override { return contacts_; }

  double energy() const noexcept override {
    double sum = 0;
    for (const auto& body : bodies_) {
      if (body.body == nullptr || !body.present) continue;
      const double* const v = dBodyGetLinearVel(body.body);
      const double* const r = dBodyGetRotation(body.body);
      const double* const w = dBodyGetAngularVel(body.body);
      // The angular velocity in the body's frame, whose axes are the principal ones.
      for (int axis = 0; axis < 3; ++axis) {
        const double turn = r[axis] * w[0] + r[4 + axis] * w[1] + r[8 + axis] * w[2];
        sum += 0.5 * body.inertia[index(axis)] * turn * turn;
      }
      sum += body.state.mass * (0.5 * dot(v, v) - dot(gravity_.data(), dBodyGetPosition(body.body)));
    }
    return sum;
  }
  double refused() const noexcept override { return static_cast<double>(refused_); }
  std::size_t bytes_used() const noexcept override { return arena_.used(); }

 private:
  struct Body {
    dBodyID body = nullptr;  ///< of what moves
    dGeomID geom = nullptr;
    BodyState state = {};  ///< its size and mass
    Vector3 inertia{};
    bool present = true;
  };
  /// A point of contact of the running step.
  struct Point {
    std::size_t contact;  ///< in contacts_
    Vector3 normal;
  };

  void add_body(const BodyModel& model) {
    auto& body = bodies_.emplace_back();
    const auto state = within_limits(model.initial);
    const auto& size = state.size;
    if (model.shape == WorldShape::Plane) {
      const auto& n = model.normal;
      const double length = std::sqrt(dot(n.data(), n.data()));
      body.geom = dCreatePlane(nullptr, n[0] / length, n[1] / length, n[2] / length, model.offset);
      return;
    }
    body.geom = model.shape == WorldShape::Sphere ? dCreateSphere(nullptr, size[0])
                : model.shape == WorldShape::Box  ? dCreateBox(nullptr, size[0], size[1], size[2])
                                                  : dCreateCapsule(nullptr, size[0], size[1]);
    if (model.moves) {
      body.body = dBodyCreate(world_);
      dGeomSetBody(body.geom, body.body);
    }
    const int number = static_cast<int>(bodies_.size()) - 1;
    apply_size(index(number), state);
    place(number, model.initial.position);
  }

  void apply_size(std::size_t number, const BodyState& to) noexcept {
    auto& body = bodies_[number];
    const auto shape = model_.bodies[number].shape;
    body.state.size = to.size;
    body.state.mass = to.mass;
    if (shape == WorldShape::Sphere)
      dGeomSphereSetRadius(body.geom, to.size[0]);
    else if (shape == WorldShape::Box)
      dGeomBoxSetLengths(body.geom, to.size[0], to.size[1], to.size[2]);
    else
      dGeomCapsuleSetParams(body.geom, to.size[0], to.size[1]);
    if (body.body == nullptr) return;
    const auto mass = mass_of(shape, to);
    dBodySetMass(body.body, &mass);
    body.inertia = {mass.I[0], mass.I[5], mass.I[10]};
  }

  void add_joint(const JointModel& model) {
    const auto on = bodies_[index(model.on)].body;
    const auto against = model.against < 0 ? nullptr : bodies_[index(model.against)].body;
    const auto &p = model.anchor, &a = model.axis;
    dJointID id = nullptr;
    const auto create = [&](auto make_joint) {
      id = make_joint(world_, nullptr);
      dJointAttach(id, on, against);
    };
    switch (model.kind) {
      case WorldJoint::Hinge:
        create(dJointCreateHinge);
        dJointSetHingeAnchor(id, p[0], p[1], p[2]);
        dJointSetHingeAxis(id, a[0], a[1], a[2]);
        if (std::isfinite(model.low)) dJointSetHingeParam(id, dParamLoStop, model.low);
        if (std::isfinite(model.high)) dJointSetHingeParam(id, dParamHiStop, model.high);
        break;
      case WorldJoint::Slider:
        create(dJointCreateSlider);
        dJointSetSliderAxis(id, a[0], a[1], a[2]);
        if (std::isfinite(model.low)) dJointSetSliderParam(id, dParamLoStop, model.low);
        if (std::isfinite(model.high)) dJointSetSliderParam(id, dParamHiStop, model.high);
        break;
      case WorldJoint::Ball:
        create(dJointCreateBall);
        dJointSetBallAnchor(id, p[0], p[1], p[2]);
        break;
      case WorldJoint::Fixed:
        create(dJointCreateFixed);
        dJointSetFixed(id);
        break;
    }
    joints_.push_back(id);
  }

  /// What the library makes with the first step. Later, larger steps take more of the arena.
  void reserve() {
    const OdeArena::Use use{arena_};
    dWorldStepReserveInfo policy{sizeof(dWorldStepReserveInfo), 1.0F, 1U << 16};
    dWorldSetStepMemoryReservationPolicy(world_, &policy);
    const RandomTurn turn{!model_.direct};
    (void)(model_.direct ? dWorldStep(world_, 1e-9) : dWorldQuickStep(world_, 1e-9));
  }

  bool linked(std::size_t one, std::size_t other) const noexcept {
    return std::any_of(model_.joints.begin(), model_.joints.end(), [&](const JointModel& joint) {
      const auto a = index(joint.on), b = index(joint.against < 0 ? joint.on : joint.against);
      return (a == one && b == other) || (a == other && b == one);
    });
  }

  /// False: there were more than fit.
  bool find_contacts() noexcept {
    contacts_.clear();
    points_.clear();
    std::fill(touching_.begin(), touching_.end(), char{0});
    for (std::size_t i = 0; i < bodies_.size(); ++i) dGeomGetAABB(bodies_[i].geom, &boxes_[6 * i]);
    bool all = true;
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      if (!bodies_[i].present || !model_.bodies[i].collides) continue;
      for (std::size_t j = i + 1; j < bodies_.size(); ++j) {
        if (!bodies_[j].present || !model_.bodies[j].collides) continue;
        if (bodies_[i].body == nullptr && bodies_[j].body == nullptr) continue;
        if (overlap(i, j) && !linked(i, j)) all = add_contacts(i, j) && all;
      }
    }
    return all;
  }

  bool overlap(std::size_t i, std::size_t j) const noexcept {
    const double *const a = &boxes_[6 * i], *const b = &boxes_[6 * j];
    return a[0] <= b[1] && b[0] <= a[1] && a[2] <= b[3] && b[2] <= a[3] && a[4] <= b[5] && b[4] <= a[5];
  }

  bool add_contacts(std::size_t i, std::size_t j) noexcept {
    // The first body of a joint must move.
    const std::size_t first = bodies_[i].body != nullptr ? i : j, second = first == i ? j : i;
    std::array<dContactGeom, kContactsOfPair> found;
    const int count = dCollide(bodies_[first].geom, bodies_[second].geom, kContactsOfPair, found.data(),
                               sizeof(dContactGeom));
    if (count == 0) return true;
    const auto room = contacts_.capacity() - points_.size();
    const auto points = std::min(index(count), room);
    if (points == 0) return false;
    const auto pair = i * bodies_.size() + j;
    touching_[pair] = 1;
    RigidContact contact{static_cast<int>(i), static_cast<int>(j), touched_[pair] == 0};
    for (std::size_t k = 0; k < points; ++k) {
      if (k == 0 || found[k].depth > contact.depth) {
        contact.depth = found[k].depth;
        contact.place = vector_of(found[k].pos);
      }
      // The normal points into the first body.
      const auto velocity = relative_velocity(first, second, found[k]);
      contact.speed = std::max(contact.speed, dot(velocity.data(), found[k].normal));
      join(first, second, found[k]);
    }
    contacts_.push_back(contact);
    return points == index(count);
  }

  /// Of the second body, less that of the first one.
  Vector3 relative_velocity(std::size_t first, std::size_t second, const dContactGeom& at) const noexcept {
    dVector3 v{}, w{};
    dBodyGetPointVel(bodies_[first].body, at.pos[0], at.pos[1], at.pos[2], v);
    if (bodies_[second].body != nullptr)
      dBodyGetPointVel(bodies_[second].body, at.pos[0], at.pos[1], at.pos[2], w);
    return {w[0] - v[0], w[1] - v[1], w[2] - v[2]};
  }

  void join(std::size_t first, std::size_t second, const dContactGeom& at) noexcept {
    const auto &one = model_.bodies[first], &other = model_.bodies[second];
    dContact contact{};
    contact.geom = at;
    auto& surface = contact.surface;
    surface.mode = dContactBounce | dContactSoftERP | dContactSoftCFM | dContactApprox1;
    surface.mu = std::sqrt(one.friction * other.friction);
    surface.bounce = std::max(one.restitution, other.restitution);
    surface.bounce_vel = model_.bounce_speed;
    surface.soft_erp = model_.erp;
    surface.soft_cfm = std::max(model_.cfm, kLeastCompliance);
    align_friction(first, second, contact);
    const auto joint = dJointCreateContact(world_, group_, &contact);
    dJointAttach(joint, bodies_[first].body, bodies_[second].body);
    auto& feedback = feedback_[points_.size()];
    feedback = {};
    dJointSetFeedback(joint, &feedback);
    points_.push_back({contacts_.size(), vector_of(at.normal)});
  }

  /// Friction is limited along two directions each. Along the motion, and across it, that is Coulomb's law.
  void align_friction(std::size_t first, std::size_t second, dContact& contact) const noexcept {
    auto slip = relative_velocity(first, second, contact.geom);
    const double along = dot(slip.data(), contact.geom.normal);
    for (std::size_t axis = 0; axis < 3; ++axis) slip[axis] -= along * contact.geom.normal[axis];
    const double speed = std::sqrt(dot(slip.data(), slip.data()));
    if (speed < kLeastSlip_m_per_s) return;
    contact.surface.mode |= dContactFDir1;
    for (std::size_t axis = 0; axis < 3; ++axis) contact.fdir1[axis] = slip[axis] / speed;
  }

  void read_impulses() noexcept {
    for (std::size_t k = 0; k < points_.size(); ++k)
      contacts_[points_[k].contact].impulse += dot(feedback_[k].f1, points_[k].normal.data()) * model_.step_s;
  }

  static void copy_body(Body& to, const Body& from) noexcept {
    if (to.body == nullptr || from.body == nullptr) {
      if (to.body != nullptr || from.body != nullptr) return;
      const double* const p = dGeomGetPosition(from.geom);
      dGeomSetPosition(to.geom, p[0], p[1], p[2]);
      return;
    }
    const double* const p = dBodyGetPosition(from.body);
    const double* const v = dBodyGetLinearVel(from.body);
    const double* const w = dBodyGetAngularVel(from.body);
    dBodySetPosition(to.body, p[0], p[1], p[2]);
    dBodySetQuaternion(to.body, dBodyGetQuaternion(from.body));
    // Setting it normalised it again, which changes last bits.
    std::memcpy(const_cast<double*>(dBodyGetQuaternion(to.body)), dBodyGetQuaternion(from.body),
                sizeof(dQuaternion));
    std::memcpy(const_cast<double*>(dBodyGetRotation(to.body)), dBodyGetRotation(from.body),
                sizeof(dMatrix3));
    dBodySetLinearVel(to.body, v[0], v[1], v[2]);
    dBodySetAngularVel(to.body, w[0], w[1], w[2]);
  }

  RigidModel model_;
  OdeArena arena_;
  dWorldID world_ = nullptr;
  dThreadingImplementationID threading_ = nullptr;
  dJointGroupID group_ = nullptr;
  std::vector<Body> bodies_;
  std::vector<dJointID> joints_;
  std::vector<double> boxes_;             ///< bounds along x, y, z of each body
  std::vector<char> touched_, touching_;  ///< by pair of bodies: in the last step, in this one
  std::vector<RigidContact> contacts_;
  std::vector<Point> points_;
  std::vector<dJointFeedback> feedback_;
  Vector3 gravity_{};
  std::int64_t refused_ = 0;
};

}  // namespace

std::size_t RigidModel::bytes() const {
  const auto power = [](std::size_t bytes) { return std::bit_ceil(std::max(bytes, std::size_t{1} << 16)); };
  const auto bodies_count = bodies.size(), joined = joints.size(), touching = index(most_contacts);
  const auto rows = 3 * touching + 6 * joined;
  // The solver: the direct one's matrix and its factors; Jacobians and lists of both.
  const auto matrix = direct ? 2 * 8 * rows * (rows + 8) : 0;
  const auto solver = matrix + 800 * rows + 1000 * bodies_count;
  // Blocks of earlier, smaller steps stay behind.
  return 2 * power(solver) + power(2 * (1024 * (touching + joined) + 2048 * bodies_count)) +
         4 * power(200 * (bodies_count + touching + joined));
}

Result<std::unique_ptr<RigidBodies>> RigidBodies::make(RigidModel model) {
  if (!start_ode())
    return tl::unexpected(Error{Errc::BadArgument, "", "the Open Dynamics Engine cannot be started",
                                "install Debian's libode8, which is built with double precision"});
  return std::make_unique<OdeBodies>(std::move(model));
}

}  // namespace tactus
