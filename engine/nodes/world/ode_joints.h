#pragma once

// Thread: [realtime], except where a function says otherwise
#include <span>
#include <vector>

#include "engine/nodes/world/ode_body.h"

namespace tactus {

/// The joints of a world: those of the file, and links, which are made, changed and removed while it runs.
/// For each link there is a joint of every kind from the start, without bodies: making it attaches one.
class OdeJoints {
 public:
  /// [control] The bodies are where they are at first, and outlive it.
  OdeJoints(dWorldID world, const RigidModel& model, std::span<const OdeBody> bodies);

  /// A link between two bodies as they are now. On a body that does not move, or with one body at both ends:
  /// none.
  void link(int joint, const JointModel& as) noexcept;
  void remove_links() noexcept;
  /// Continues as `other` does; changes the poses of bodies.
  void copy_links(const OdeJoints& other) noexcept;
  /// Implicit in the step, so that it is stable for every stiffness and damping.
  void set_spring(int joint, double stiffness, double damping) noexcept;
  void drive(int joint, double effort, double second) noexcept;
  /// A joint acts while both of its bodies are present.
  void follow_presence() noexcept;

  double position(int joint) const noexcept;
  double rate(int joint) const noexcept;
  bool linked(std::size_t one, std::size_t other) const noexcept;

 private:
  struct Joint {
    dJointID id = nullptr;  ///< nullptr: a link that is not made
    JointModel model = {};
    OdePose on = {}, against = {};  ///< of the bodies when it was made
    double stiffness = 0, damping = 0;
    std::vector<dJointID> kinds = {};  ///< of a link: a joint of each kind
  };

  dBodyID body(int number) const noexcept {
    return number < 0 ? nullptr : bodies_[static_cast<std::size_t>(number)].body;
  }
  void attach(Joint& joint) noexcept;

  double step_s_;
  std::span<const OdeBody> bodies_;
  std::vector<Joint> joints_;  ///< of the file, then links
};

}  // namespace tactus
