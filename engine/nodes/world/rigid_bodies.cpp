#include "engine/nodes/world/rigid_bodies.h"

#include <ode/ode.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <utility>

#include "engine/core/index.h"
#include "engine/nodes/world/ode_body.h"
#include "engine/nodes/world/ode_contacts.h"
#include "engine/nodes/world/ode_joints.h"
#include "engine/nodes/world/ode_memory.h"
#include "engine/nodes/world/world_elements.h"

namespace tactus {
namespace {

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
    dWorldSetQuickStepNumIterations(world_, model_.iterations);
    if (std::isfinite(model_.correction_speed))
      dWorldSetContactMaxCorrectingVel(world_, model_.correction_speed);
    bodies_.reserve(model_.bodies.size());  // they stay where they are
    attempt([&] {
      for (const auto& body : model_.bodies) add_body(body);
      joints_ = std::make_unique<OdeJoints>(world_, model_, bodies_);
    });
    contacts_ = std::make_unique<OdeContacts>(world_, model_, bodies_, *joints_);
    attempt([&] { reserve(); });
    reset();
  }
  bool broken() const { return broken_; }

  ~OdeBodies() override {
    if (broken_) {
      lose();
      return;
    }
    const OdeArena::Use use{arena_};
    contacts_.reset();
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
    attempt([&] { apply_size(index(number), to); });
  }

  void place(int number, const Vector3& p) noexcept override {
    attempt([&] { put(number, p); });
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
    joints_->follow_presence();
  }
  bool present(int body) const noexcept override { return bodies_[index(body)].present; }

  void push(int body, const Vector3& f) noexcept override {
    const auto& one = bodies_[index(body)];
    if (one.body != nullptr && one.present) dBodyAddForce(one.body, f[0], f[1], f[2]);
  }

  void drive(int joint, double effort, double second) noexcept override {
    joints_->drive(joint, effort, second);
  }
  void link(int joint, const JointModel& as) noexcept override {
    attempt([&] { joints_->link(joint, as); });
  }
  void set_spring(int joint, double stiffness, double damping) noexcept override {
    joints_->set_spring(joint, stiffness, damping);
  }

  void step() noexcept override {
    const OdeArena::Use use{arena_};
    bool all = false, done = false;
    attempt([&] { all = contacts_->find(); });
    {
      const RandomTurn turn{!model_.direct};
      attempt([&] {
        done =
            (model_.direct ? dWorldStep(world_, model_.step_s) : dWorldQuickStep(world_, model_.step_s)) != 0;
      });
    }
    if (broken_) return;
    if (done) contacts_->read_impulses();
    if (!all || !done) ++refused_;
    contacts_->release();
  }

  bool within_range() const noexcept override {
    constexpr double kMost = 1e9;
    if (broken_) return false;
    const auto small = [](const double* v) {
      return std::abs(v[0]) <= kMost && std::abs(v[1]) <= kMost && std::abs(v[2]) <= kMost;
    };
    return std::ranges::all_of(bodies_, [&](const OdeBody& body) {
      return body.body == nullptr || !body.present ||
             (small(dBodyGetPosition(body.body)) && small(dBodyGetLinearVel(body.body)) &&
              small(dBodyGetAngularVel(body.body)));
    });
  }

  void reset() noexcept override {
    if (broken_) return;
    set_gravity({});
    joints_->remove_links();
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      const auto& initial = model_.bodies[i].initial;
      resize(static_cast<int>(i), initial);
      place(static_cast<int>(i), initial.position);
      launch(static_cast<int>(i), initial.velocity);
      set_present(static_cast<int>(i), model_.bodies[i].present);
    }
    contacts_->clear();
    refused_ = 0;
  }

  void copy(const RigidBodies& from) noexcept override {
    const auto& other = static_cast<const OdeBodies&>(from);
    if (broken_ || other.broken_ || other.bodies_.size() != bodies_.size()) return;
    set_gravity(other.gravity_);
    joints_->copy_links(*other.joints_);
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      if (model_.bodies[i].shape == WorldShape::Plane) continue;
      copy_body(bodies_[i], other.bodies_[i]);
      resize(static_cast<int>(i), other.bodies_[i].state);
      set_present(static_cast<int>(i), other.bodies_[i].present);
    }
    contacts_->copy(*other.contacts_);
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
  std::array<double, 4> turn(int body) const noexcept override {
    const auto geom = bodies_[index(body)].geom;
    if (model_.bodies[index(body)].shape == WorldShape::Plane) return {1, 0, 0, 0};
    dQuaternion q;
    dGeomGetQuaternion(geom, q);
    return {q[0], q[1], q[2], q[3]};
  }
  const BodyState& state(int body) const noexcept override { return bodies_[index(body)].state; }

  double joint_position(int joint) const noexcept override { return joints_->position(joint); }
  double joint_rate(int joint) const noexcept override { return joints_->rate(joint); }

  std::span<const RigidContact> contacts() const noexcept override { return contacts_->all(); }

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
  template <class Call>
  void attempt(Call call) noexcept {
    broken_ = broken_ || !survives(call);
  }
  /// What the library left in the middle of something is not safe to free.
  void lose() noexcept {
    (void)contacts_.release();
    (void)joints_.release();
    arena_.lose();
  }

  void put(int number, const Vector3& p) noexcept {
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
    put(number, model.initial.position);
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

  /// What the library makes with the first step. Later, larger steps take more of the arena.
  void reserve() {
    const OdeArena::Use use{arena_};
    dWorldStepReserveInfo policy{sizeof(dWorldStepReserveInfo), 1.0F, 1U << 16};
    dWorldSetStepMemoryReservationPolicy(world_, &policy);
    const RandomTurn turn{!model_.direct};
    (void)(model_.direct ? dWorldStep(world_, 1e-9) : dWorldQuickStep(world_, 1e-9));
  }

  static void copy_body(OdeBody& to, const OdeBody& from) noexcept {
    if (to.body == nullptr || from.body == nullptr) {
      if (to.body != nullptr || from.body != nullptr) return;
      const double* const p = dGeomGetPosition(from.geom);
      dGeomSetPosition(to.geom, p[0], p[1], p[2]);
      return;
    }
    const double* const v = dBodyGetLinearVel(from.body);
    const double* const w = dBodyGetAngularVel(from.body);
    set_pose(to.body, pose_of(from.body));
    dBodySetLinearVel(to.body, v[0], v[1], v[2]);
    dBodySetAngularVel(to.body, w[0], w[1], w[2]);
  }

  RigidModel model_;
  OdeArena arena_;
  dWorldID world_ = nullptr;
  dThreadingImplementationID threading_ = nullptr;
  std::vector<OdeBody> bodies_;
  std::unique_ptr<OdeJoints> joints_;
  std::unique_ptr<OdeContacts> contacts_;
  Vector3 gravity_{};
  std::int64_t refused_ = 0;
  bool broken_ = false;  ///< by an assertion of the library: at rest for ever
};

}  // namespace

std::size_t RigidModel::bytes() const {
  const auto power = [](std::size_t bytes) { return std::bit_ceil(std::max(bytes, std::size_t{1} << 16)); };
  const auto bodies_count = bodies.size(), touching = index(most_contacts);
  const auto joined = joints.size() + index(links), made = joints.size() + index(kJointKinds * links);
  const auto rows = 3 * touching + 6 * joined;
  // The solver: the direct one's matrix and its factors; Jacobians and lists of both.
  const auto matrix = direct ? 2 * 8 * rows * (rows + 8) : 0;
  const auto solver = matrix + 800 * rows + 1000 * bodies_count;
  // Blocks of earlier, smaller steps stay behind.
  return 2 * power(solver) + power(2 * (1024 * (touching + joined) + 2048 * bodies_count)) +
         4 * power(200 * (bodies_count + touching + made));
}

Result<std::unique_ptr<RigidBodies>> RigidBodies::make(RigidModel model) {
  if (!start_ode())
    return tl::unexpected(Error{Errc::BadArgument, "", "the Open Dynamics Engine cannot be started",
                                "install Debian's libode8, which is built with double precision"});
  auto bodies = std::make_unique<OdeBodies>(std::move(model));
  if (bodies->broken())
    return tl::unexpected(Error{Errc::OutOfRange, "",
                                "the Open Dynamics Engine cannot step its bodies and joints",
                                "look for a place, a size or a mass that is much too large or too small"});
  return bodies;
}

}  // namespace tactus
