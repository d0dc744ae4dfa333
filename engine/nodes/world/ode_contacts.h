#pragma once

// Thread: [realtime], except where a function says otherwise
#include <cstddef>
#include <span>
#include <vector>

#include "engine/nodes/world/ode_body.h"
#include "engine/nodes/world/ode_joints.h"

namespace tactus {

/// The contacts of a world: finds them before each step, and what they did after it.
class OdeContacts {
 public:
  /// [control] `model`, `bodies` and `joints` outlive it.
  OdeContacts(dWorldID world, const RigidModel& model, std::span<const OdeBody> bodies,
              const OdeJoints& joints);
  ~OdeContacts();
  OdeContacts(const OdeContacts&) = delete;
  OdeContacts& operator=(const OdeContacts&) = delete;

  /// Contacts of the next step. False: there were more than fit.
  bool find() noexcept;
  /// After a step that was computed.
  void read_impulses() noexcept;
  /// After each step.
  void release() noexcept;
  void clear() noexcept;
  void copy(const OdeContacts& other) noexcept;

  std::span<const RigidContact> all() const noexcept { return contacts_; }

 private:
  /// A point of contact of the running step.
  struct Point {
    std::size_t contact;  ///< in contacts_
    Vector3 normal;
  };

  bool overlap(std::size_t i, std::size_t j) const noexcept;
  bool add(std::size_t i, std::size_t j) noexcept;
  Vector3 relative_velocity(std::size_t first, std::size_t second, const dContactGeom& at) const noexcept;
  void join(std::size_t first, std::size_t second, const dContactGeom& at) noexcept;
  void align_friction(std::size_t first, std::size_t second, dContact& contact) const noexcept;

  dWorldID world_;
  const RigidModel& model_;
  std::span<const OdeBody> bodies_;
  const OdeJoints& joints_;
  dJointGroupID group_;
  std::vector<double> boxes_;             ///< bounds along x, y, z of each body
  std::vector<char> touched_, touching_;  ///< by pair of bodies: in the last step, in this one
  std::vector<RigidContact> contacts_;
  std::vector<Point> points_;
  std::vector<dJointFeedback> feedback_;
};

}  // namespace tactus
