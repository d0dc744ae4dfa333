#include "engine/nodes/world/ode_contacts.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "engine/core/index.h"

namespace tactus {
namespace {

constexpr int kContactsOfPair = 4;
/// Two bodies may have more points of contact than their rank: without a little compliance the matrix is
/// singular. It changes an impulse by 1e-10 m / step, where m is the mass.
constexpr double kLeastCompliance = 1e-10;
constexpr double kLeastSlip_m_per_s = 1e-6;

}  // namespace

OdeContacts::OdeContacts(dWorldID world, const RigidModel& model, std::span<const OdeBody> bodies,
                         const OdeJoints& joints)
    : world_(world),
      model_(model),
      bodies_(bodies),
      joints_(joints),
      group_(dJointGroupCreate(0)),
      boxes_(bodies.size() * 6),
      touched_(bodies.size() * bodies.size()),
      touching_(touched_) {
  const auto most = index(model.most_contacts);
  contacts_.reserve(most);
  points_.reserve(most);
  feedback_.resize(most);
}

OdeContacts::~OdeContacts() { dJointGroupDestroy(group_); }

bool OdeContacts::find() noexcept {
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
      if (overlap(i, j) && !joints_.linked(i, j)) all = add(i, j) && all;
    }
  }
  return all;
}

bool OdeContacts::overlap(std::size_t i, std::size_t j) const noexcept {
  const double *const a = &boxes_[6 * i], *const b = &boxes_[6 * j];
  return a[0] <= b[1] && b[0] <= a[1] && a[2] <= b[3] && b[2] <= a[3] && a[4] <= b[5] && b[4] <= a[5];
}

bool OdeContacts::add(std::size_t i, std::size_t j) noexcept {
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
Vector3 OdeContacts::relative_velocity(std::size_t first, std::size_t second,
                                       const dContactGeom& at) const noexcept {
  dVector3 v{}, w{};
  dBodyGetPointVel(bodies_[first].body, at.pos[0], at.pos[1], at.pos[2], v);
  if (bodies_[second].body != nullptr)
    dBodyGetPointVel(bodies_[second].body, at.pos[0], at.pos[1], at.pos[2], w);
  return {w[0] - v[0], w[1] - v[1], w[2] - v[2]};
}

void OdeContacts::join(std::size_t first, std::size_t second, const dContactGeom& at) noexcept {
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
void OdeContacts::align_friction(std::size_t first, std::size_t second, dContact& contact) const noexcept {
  auto slip = relative_velocity(first, second, contact.geom);
  const double along = dot(slip.data(), contact.geom.normal);
  for (std::size_t axis = 0; axis < 3; ++axis) slip[axis] -= along * contact.geom.normal[axis];
  const double speed = std::sqrt(dot(slip.data(), slip.data()));
  if (speed < kLeastSlip_m_per_s) return;
  contact.surface.mode |= dContactFDir1;
  for (std::size_t axis = 0; axis < 3; ++axis) contact.fdir1[axis] = slip[axis] / speed;
}

void OdeContacts::read_impulses() noexcept {
  for (std::size_t k = 0; k < points_.size(); ++k)
    contacts_[points_[k].contact].impulse += dot(feedback_[k].f1, points_[k].normal.data()) * model_.step_s;
}

void OdeContacts::release() noexcept {
  dJointGroupEmpty(group_);
  touched_.swap(touching_);
}

void OdeContacts::clear() noexcept {
  std::fill(touched_.begin(), touched_.end(), char{0});
  contacts_.clear();
}

void OdeContacts::copy(const OdeContacts& other) noexcept {
  touched_ = other.touched_;  // of the same size: nothing is allocated
  contacts_.assign(other.contacts_.begin(),
                   other.contacts_.begin() + std::min(std::ssize(other.contacts_),
                                                      static_cast<std::ptrdiff_t>(contacts_.capacity())));
}

}  // namespace tactus
